import { useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef } from "react";
import uPlot from "uplot";
import { plainTicks } from "../../plots/chart/axes";
import { drawMarks, markAt, type PlotMark } from "../../plots/chart/marks";
import { axesOf, PADDING, plotWidth, seriesOf } from "../../plots/chart/painter";
import { INK, type Ink } from "../../ui/colours";
import { plain } from "../../ui/format";
import { STRETCH_WORD, type Stretch } from "./course";
import type { PlotLine, QuickChart } from "./quickCharts";

/** A part of the time that is shown [s]. */
export interface TimeWindow {
  readonly from: number;
  readonly to: number;
}
/** Told what is shown, null for all. */
export type Zoomed = (to: TimeWindow | null) => void;

/** Where the cursor is on x, and on the width of the plot. */
export interface CursorPlace {
  readonly x: number;
  readonly share: number;
}

/** A place on x to go to; another object each time, as one may go there again. */
export interface Seek {
  readonly at: number;
}

/** Most of x that is shown about a place that was gone to [s], on either side. */
const ABOUT_S = 2;

interface Props {
  readonly chart: QuickChart;
  /** Plots of one key share cursor and zoom. */
  readonly group: string;
  /** What x counts: seconds, or cycles. */
  readonly unitX: string;
  /** Told where the cursor is, null off the plot. */
  readonly onCursor?: ((place: CursorPlace | null) => void) | undefined;
  /** Told all of x that is shown. */
  readonly onRange?: ((range: TimeWindow) => void) | undefined;
  readonly onZoom?: Zoomed | undefined;
  readonly marks: readonly PlotMark[];
  readonly seek: Seek | null;
  /** Told the place of a mark that was clicked. */
  readonly onSeek?: ((at: number) => void) | undefined;
  /** What is shown at first, null for all. */
  readonly window?: TimeWindow | null;
}

/** One plot of a recording: drag zooms along x, a double click shows all again, the cursor is common to all. */
export function QuickPlot({ chart, group, unitX, window = null, ...rest }: Props) {
  const { onCursor, onRange, onZoom, marks, seek, onSeek } = rest;
  const drawn = useRef<uPlot>(null);
  const shown = useRef(marks);
  const host = useRef<HTMLDivElement>(null);
  const values = useRef<(HTMLElement | null)[]>([]);
  const ink = INK[useComputedColorScheme("dark")];
  const named = chart.lines.map((line, i) => ({ line, i })).filter(({ line }) => line.look !== "thin");
  useEffect(() => {
    const element = host.current;
    if (!element) return;
    const read = (plot: uPlot) => {
      const at = plot.cursor.idx ?? null;
      chart.lines.forEach((_, i) => {
        const value = at === null ? null : plot.data[i + 1][at];
        const box = values.current[i];
        if (box) box.textContent = value === null || value === undefined ? "" : plain(value, 2);
      });
      const share = (plot.cursor.left ?? 0) / plotWidth(plot);
      onCursor?.(at === null ? null : { x: plot.data[0][at], share });
    };
    const zoomed = (plot: uPlot) => {
      const { min, max } = plot.scales.x;
      if (min !== undefined && max !== undefined) onRange?.({ from: min, to: max });
      onZoom?.(windowOf(plot, window));
    };
    const marked = (plot: uPlot) => drawMarks(plot, shown.current, ink);
    const plot = new uPlot(
      optionsOf(chart, element, { group, unitX, ink, read, zoomed, marked }),
      chart.columns,
      element,
    );
    drawn.current = plot;
    plot.over.addEventListener("click", (event) => {
      const mark = markAt(plot, shown.current, event.offsetX);
      if (mark) onSeek?.(mark.at);
    });
    if (window) plot.setScale("x", { min: window.from, max: window.to });
    const sizes = new ResizeObserver(([{ contentRect }]) => {
      plot.setSize({ width: Math.floor(contentRect.width), height: Math.floor(contentRect.height) });
    });
    sizes.observe(element);
    return () => {
      sizes.disconnect();
      plot.destroy();
    };
  }, [chart, group, unitX, ink, onCursor, onRange, onZoom, onSeek, window]);
  useEffect(() => {
    shown.current = marks;
    drawn.current?.redraw(false);
  }, [marks]);
  useEffect(() => {
    if (!seek) return undefined;
    const frame = requestAnimationFrame(() => {
      if (drawn.current) goTo(drawn.current, seek.at);
    }); // after the plot was drawn with all that it was given
    return () => {
      cancelAnimationFrame(frame);
    };
  }, [seek]);
  return (
    <figure className="quick-plot" data-testid="quick-plot">
      <figcaption>
        <b>
          {chart.title}
          {chart.unit === "" ? "" : ` [${chart.unit}]`}
        </b>
        {named.map(({ line, i }) => (
          <span key={line.label} className="quick-line">
            <Sample line={line} /> {line.label}{" "}
            <span
              className="number"
              ref={(element) => {
                values.current[i] = element;
              }}
            />
          </span>
        ))}
      </figcaption>
      <div className="quick-canvas" ref={host} role="img" aria-label={`Plot of ${chart.title}`} />
    </figure>
  );
}

const DASHES = { solid: [], dashed: [6, 4], dots: [2, 2], thin: [2, 2] } as const;

/** A line as it looks in the plot. */
export function Sample({ line }: { readonly line: PlotLine }) {
  return (
    <svg width={22} height={8} aria-hidden>
      <line
        x1={0}
        x2={22}
        y1={4}
        y2={4}
        stroke={line.colour}
        strokeWidth={line.look === "thin" ? 1 : 2}
        strokeDasharray={(line.dash ?? DASHES[line.look]).join(" ")}
      />
    </svg>
  );
}

interface Look {
  readonly group: string;
  readonly unitX: string;
  readonly ink: Ink;
  readonly read: (plot: uPlot) => void;
  readonly zoomed: (plot: uPlot) => void;
  readonly marked: (plot: uPlot) => void;
}

/** Show what is about the place `at`, with the cursor there. */
function goTo(plot: uPlot, at: number): void {
  const [first, last] = [plot.data[0].at(0) ?? 0, plot.data[0].at(-1) ?? 0];
  plot.batch(() => {
    plot.setScale("x", { min: Math.max(first, at - ABOUT_S), max: Math.min(last, at + ABOUT_S) });
  });
  plot.setCursor({ left: plot.valToPos(at, "x"), top: plot.bbox.height / devicePixelRatio / 2 });
}

/** What someone chose to see of its time, null where that is all of it or what was shown `first`. */
function windowOf({ scales, data }: uPlot, first: TimeWindow | null): TimeWindow | null {
  const [from, to] = [scales.x.min ?? 0, scales.x.max ?? 0];
  const [begin, end] = [data[0].at(0) ?? 0, data[0].at(-1) ?? 0];
  if ((from <= begin && to >= end) || (from === first?.from && to === first.to)) return null;
  return { from: Math.max(0, from), to };
}

function optionsOf(
  chart: QuickChart,
  host: HTMLElement,
  { group, unitX, ink, read, zoomed, marked }: Look,
): uPlot.Options {
  return {
    width: Math.max(50, host.clientWidth),
    height: Math.max(50, host.clientHeight),
    legend: { show: false },
    padding: PADDING,
    cursor: { sync: { key: group }, drag: { x: true, y: false }, y: false, points: { size: 5 } },
    scales: { x: { time: false } },
    axes: axesOf(() => ink, plainTicks(unitX)),
    series: [{}, ...chart.lines.map(lineOf)],
    hooks: {
      drawClear: [
        (plot) => {
          paintStretches(plot, chart.stretches ?? [], ink);
        },
      ],
      setCursor: [read],
      draw: [marked],
      setScale: [
        (plot, key) => {
          if (key === "x") zoomed(plot);
        },
      ],
    },
  };
}

/** Shade what is not of the run, with its name where there is room. */
function paintStretches(plot: uPlot, stretches: readonly Stretch[], ink: Ink): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.font = `${10 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textBaseline = "top";
  for (const { kind, start, end } of stretches) {
    if (kind === "run") continue;
    const [from, to] = [start, end].map((t) => plot.valToPos(t, "x", true));
    const [left, right] = [Math.max(from, bbox.left), Math.min(to, bbox.left + bbox.width)];
    ctx.globalAlpha = kind === "approach" ? 0.1 : 0.22;
    ctx.fillStyle = ink.soft;
    ctx.fillRect(left, bbox.top, right - left, bbox.height);
    const word = STRETCH_WORD[kind];
    if (ctx.measureText(word).width + 8 * devicePixelRatio > right - left) continue;
    ctx.globalAlpha = 1;
    ctx.fillText(word, left + 4 * devicePixelRatio, bbox.top + 7 * devicePixelRatio);
  }
  ctx.restore();
}

function lineOf(line: PlotLine): uPlot.Series {
  const look = seriesOf({ ...line, key: "", channel: 0, name: line.label, tag: "", named: false });
  return line.dash ? { ...look, dash: [...line.dash] } : look;
}
