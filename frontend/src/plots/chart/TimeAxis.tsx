import { useElementSize } from "@mantine/hooks";
import { useEffect, useRef, type CSSProperties } from "react";
import { SIDES, type Marked } from "./axes";
import type { TimeCursor } from "./readout";
import type { Range } from "./view";

interface Props {
  /** What the plots above it show. */
  readonly range: Range;
  readonly marked: Marked;
  readonly cursor: TimeCursor;
  readonly style?: CSSProperties;
}

/**
 * The time under a column of plots, whose grid lines stand on its marks. It follows the rig without being painted:
 * seconds before the newest stay where they are.
 */
export function TimeAxis({ range, marked, cursor, style }: Props) {
  const { ref, width } = useElementSize();
  const tag = useRef<HTMLElement>(null);
  useEffect(() => (tag.current ? cursor.add(tag.current) : undefined), [cursor]);
  const ticks = width === 0 ? [] : marked(range, width);
  return (
    <div className="time-axis" data-testid="time-axis" style={style}>
      <div ref={ref} style={{ marginLeft: SIDES.left, marginRight: SIDES.right }}>
        {ticks.map(({ at, text }) => (
          <span key={at} style={{ left: `${(100 * (at - range.from)) / (range.to - range.from)}%` }}>
            {text}
          </span>
        ))}
        <b ref={tag} className="number" data-testid="cursor-time" hidden />
      </div>
    </div>
  );
}
