import { useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef, type CSSProperties, type ReactNode } from "react";
import { INK } from "../../ui/colours";
import type { Chart } from "./charts";
import type { TimeCursor } from "./readout";
import { ChartPainter } from "./painter";
import type { Gesture } from "./view";

interface Props {
  readonly chart: Chart;
  /** Told the painter when it is there; returns what to do when it goes. */
  readonly onPainter: (painter: ChartPainter) => () => void;
  readonly onGesture: (gesture: Gesture) => void;
  readonly cursor: TimeCursor;
  /** Its place among the plots. */
  readonly style?: CSSProperties;
  /** Buttons beside the title. */
  readonly children: ReactNode;
}

/** Values that stand beside each other in large figures, at most. */
const MANY = 3;

/** A chart with its title, and per line a sample of its look beside its newest value. */
export function ChartBox({ chart, onPainter, onGesture, cursor, style, children }: Props) {
  const host = useRef<HTMLDivElement>(null);
  const values = useRef<(HTMLElement | null)[]>([]);
  const painter = useRef<ChartPainter>(null);
  const scheme = useComputedColorScheme("dark");
  const first = useRef(scheme);
  const listed = chart.lines.map((line, i) => ({ line, i })).filter(({ line }) => line.look !== "thin");
  useEffect(() => {
    const element = host.current;
    if (!element) return;
    const made = new ChartPainter(chart, element, values.current, INK[first.current], cursor, onGesture);
    painter.current = made;
    const forget = onPainter(made);
    const sizes = new ResizeObserver(([entry]) => {
      made.resize(Math.floor(entry.contentRect.width), Math.floor(entry.contentRect.height));
    });
    sizes.observe(element);
    const sight = new IntersectionObserver((entries) => {
      made.seen = entries.at(-1)?.isIntersecting ?? true;
    });
    sight.observe(element);
    return () => {
      sizes.disconnect();
      sight.disconnect();
      forget();
      made.destroy();
    };
  }, [chart, onPainter, onGesture, cursor]);
  useEffect(() => {
    first.current = scheme;
    painter.current?.useInk(INK[scheme]);
  }, [scheme]);
  return (
    <figure className="chart" aria-label={`${chart.title} over time`} data-testid="chart" style={style}>
      <figcaption>
        <span className="chart-title">
          {chart.title} <span className="unit">{chart.unit}</span>
        </span>
        <span className="chart-values" data-many={listed.length > MANY}>
          {listed.map(({ line, i }) => (
            <span key={line.key} className="chart-value" title={line.name}>
              <i className={`swatch swatch-${line.look}`} style={{ color: line.colour }} />
              {line.named ? <b>{line.tag}</b> : null}
              <span
                className="number"
                ref={(element) => {
                  values.current[i] = element;
                }}
              />
            </span>
          ))}
        </span>
        {children}
      </figcaption>
      <div ref={host} className="chart-host" />
    </figure>
  );
}
