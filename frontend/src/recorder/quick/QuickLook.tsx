import { Loader } from "@mantine/core";
import { useCallback, useEffect, useMemo, useRef } from "react";
import type { Quick } from "../../api/types";
import { PathCanvas, type DrawnPath, type PathMark } from "./PathCanvas";
import { pathsOf } from "./paths";
import { quickCharts, type QuickChart } from "./quickCharts";
import { QuickPlot, Sample, type Zoomed } from "./QuickPlot";
import { useQuick } from "./useQuick";

interface Props {
  readonly id: string;
  readonly running: boolean;
  readonly onZoom: Zoomed;
  /** Its plots stand. */
  readonly onDrawn: () => void;
}

/** The main signals and the tip's path of a recording, without rerun. */
export function QuickLook({ id, running, onZoom, onDrawn }: Props) {
  const { looks, problem } = useQuick([id], running);
  const quick = looks?.at(0);
  if (problem !== "") return <p className="panel advice" role="alert">No quick look: {problem}</p>; // prettier-ignore
  if (!quick) return <Loader m="xl" data-testid="quick-loading" />;
  if (quick.rows === 0) return <p className="panel note">Nothing is recorded in it.</p>;
  return <Shown quick={quick} onZoom={onZoom} onDrawn={onDrawn} />;
}

interface ShownProps {
  readonly quick: Quick;
  readonly onZoom: Zoomed;
  readonly onDrawn: () => void;
}

function Shown({ quick, onZoom, onDrawn }: ShownProps) {
  useEffect(onDrawn, [onDrawn]);
  const charts = useMemo(() => quickCharts(quick), [quick]);
  const paths = useMemo(() => pathsOf(quick), [quick]);
  return <PlotsAndPath charts={charts} paths={paths} group="quick" unitX="s" onZoom={onZoom} />;
}

interface PlotsProps {
  readonly charts: readonly QuickChart[];
  readonly paths: readonly DrawnPath[];
  readonly group: string;
  readonly unitX: string;
  readonly onZoom?: Zoomed | undefined;
}

/** Plots beside the paths; where the cursor is on time, each path is marked. */
export function PlotsAndPath({ charts, paths, group, unitX, onZoom }: PlotsProps) {
  const mark = useRef<PathMark>(null);
  const follow = useCallback((x: number | null) => {
    mark.current?.show(x);
  }, []);
  return (
    <div className="quick" data-testid="quick">
      <div className="quick-plots">
        {charts.map((chart, i) => (
          <QuickPlot
            key={chart.title}
            chart={chart}
            group={group}
            unitX={unitX}
            onCursor={i === 0 && unitX === "s" ? follow : undefined}
            onZoom={i === 0 ? onZoom : undefined}
          />
        ))}
      </div>
      <figure className="quick-side">
        <figcaption>
          {paths.map(({ label, colour, dash }) => (
            <span key={label} className="quick-line">
              <Sample line={{ label, colour, dash, look: "solid" }} /> {label}
            </span>
          ))}
        </figcaption>
        <PathCanvas paths={paths} mark={mark} />
      </figure>
    </div>
  );
}
