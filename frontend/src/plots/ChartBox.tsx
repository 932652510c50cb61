import { useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef } from "react";
import { INK } from "../roles";
import type { Chart } from "./charts";
import { ChartPainter } from "./painter";

interface Props {
  readonly chart: Chart;
  /** Told the painter when it is there, and null when it is gone. */
  readonly onPainter: (painter: ChartPainter | null) => void;
}

/** A chart with its title, and per line a sample of its look beside its value. */
export function ChartBox({ chart, onPainter }: Props) {
  const host = useRef<HTMLDivElement>(null);
  const values = useRef<(HTMLElement | null)[]>([]);
  const painter = useRef<ChartPainter>(null);
  const scheme = useComputedColorScheme("dark");
  const first = useRef(scheme);
  const listed = chart.lines.map((line, i) => ({ line, i })).filter(({ line }) => line.look !== "thin");
  useEffect(() => {
    const element = host.current;
    if (!element) return;
    const made = new ChartPainter(chart, element, values.current, INK[first.current]);
    painter.current = made;
    onPainter(made);
    const sizes = new ResizeObserver(([entry]) => {
      made.resize(Math.floor(entry.contentRect.width), Math.floor(entry.contentRect.height));
    });
    sizes.observe(element);
    return () => {
      sizes.disconnect();
      onPainter(null);
      made.destroy();
    };
  }, [chart, onPainter]);
  useEffect(() => {
    painter.current?.useInk(INK[scheme]);
  }, [scheme]);
  return (
    <figure className="chart" aria-label={`${chart.title} over time`}>
      <figcaption>
        <span className="chart-title">
          {chart.title} <span className="unit">{chart.unit}</span>
        </span>
        {listed.map(({ line, i }) => (
          <span key={line.name} className="chart-value" title={line.name}>
            {chart.numbered ? (
              <b style={{ color: line.colour }}>{line.name}</b>
            ) : (
              <i className={`swatch swatch-${line.look}`} style={{ color: line.colour }} />
            )}
            <span
              className="number"
              ref={(element) => {
                values.current[i] = element;
              }}
            />
          </span>
        ))}
      </figcaption>
      <div ref={host} className="chart-host" />
    </figure>
  );
}
