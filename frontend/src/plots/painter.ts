import uPlot from "uplot";
import { plain } from "../state/format";
import type { Ink } from "../roles";
import { columnsOf, type Chart, type Line } from "./charts";
import type { Ring } from "./ring";
import type { PlotChannel } from "../api/types";
import { emptyData, extractWindow, niceRange, type PlotData } from "./window";

const DOT_EVERY = 6;
const PX_PER_COLUMN = 2;

/** Where the numbers beside a chart's title are written: one element per line, or null. */
export type Readout = readonly (HTMLElement | null)[];

/** One uPlot chart that follows the ring without React. */
export class ChartPainter {
  private readonly plot: uPlot;
  private readonly data: PlotData;
  private range: [number, number] = [0, 1];
  private seconds = 10;
  private ink: Ink;

  constructor(
    private readonly chart: Chart,
    host: HTMLElement,
    private readonly readout: Readout,
    ink: Ink,
  ) {
    this.ink = ink;
    this.data = emptyData(chart.lines.length);
    this.plot = new uPlot(this.options(host), this.columns(), host);
  }

  destroy(): void {
    this.plot.destroy();
  }

  resize(width: number, height: number): void {
    if (width > 0 && height > 0) this.plot.setSize({ width, height });
  }

  useInk(ink: Ink): void {
    this.ink = ink;
    this.plot.redraw(false, true);
  }

  /** Show the last `seconds` before `end` [s on the rig's clock]. */
  show(ring: Ring, channels: readonly PlotChannel[], end: number, seconds: number): void {
    const columns = Math.max(20, Math.round(this.plot.width / PX_PER_COLUMN));
    const span = { from: end - seconds, to: end, columns };
    this.seconds = seconds;
    extractWindow(ring, columnsOf(this.chart, channels), span, this.chart.scale, this.data);
    this.range = niceRange(this.data, this.chart.least, this.chart.fromZero);
    this.plot.setData(this.columns());
    this.write();
  }

  private columns(): uPlot.AlignedData {
    return [this.data.x, ...this.data.series];
  }

  /** The values under the cursor, else the newest ones. */
  private write(): void {
    const at = this.plot.cursor.idx ?? this.data.x.length - 1;
    this.readout.forEach((element, i) => {
      const text = plain(at < 0 ? null : this.data.series[i].at(at), this.chart.digits);
      if (element && element.textContent !== text) element.textContent = text;
    });
  }

  private options(host: HTMLElement): uPlot.Options {
    return {
      width: Math.max(50, host.clientWidth),
      height: Math.max(50, host.clientHeight),
      legend: { show: false },
      padding: [6, 10, 0, 0],
      cursor: { sync: { key: "live" }, drag: { x: false, y: false }, y: false, points: { size: 5 } },
      scales: {
        x: { time: false, range: () => [-this.seconds, 0] },
        y: { range: () => this.range },
      },
      axes: [
        this.axis(18, secondsLabels),
        this.axis(40, (splits) => splits.map((y) => String(Number(y.toFixed(3))))),
      ],
      series: [{}, ...this.chart.lines.map(seriesOf)],
      hooks: {
        setCursor: [
          () => {
            this.write();
          },
        ],
        draw: [
          () => {
            this.drawNames();
          },
        ],
      },
    };
  }

  private axis(size: number, labels: (splits: number[]) => string[]): uPlot.Axis {
    return {
      size,
      gap: 2,
      font: "10px system-ui, sans-serif",
      stroke: () => this.ink.soft,
      grid: { stroke: () => this.ink.gridMajor, width: 1 },
      ticks: { show: false },
      values: (_plot, splits) => labels(splits),
      space: 34,
    };
  }

  private drawNames(): void {
    if (!this.chart.numbered) return;
    const { ctx, bbox } = this.plot;
    ctx.save();
    ctx.font = `${10 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "right";
    let taken = Infinity;
    for (const { name, colour, y } of this.lineEnds()) {
      const at = Math.min(y, taken - 10 * devicePixelRatio);
      taken = at;
      ctx.fillStyle = colour;
      ctx.fillText(name, bbox.left + bbox.width - 3, at - 2);
    }
    ctx.restore();
  }

  /** Measured lines from the lowest on the screen to the highest. */
  private lineEnds(): { name: string; colour: string; y: number }[] {
    return this.chart.lines
      .flatMap((line, i) => {
        const value = this.data.series[i].at(-1);
        if (line.look !== "solid" || typeof value !== "number") return [];
        return [{ name: line.name, colour: line.colour, y: this.plot.valToPos(value, "y", true) }];
      })
      .sort((a, b) => b.y - a.y);
  }
}

/** The first label would run into the y axis; the last one carries the unit. */
function secondsLabels(splits: number[]): string[] {
  return splits.map((t, i) => (i === 0 ? "" : i === splits.length - 1 ? `${t} s` : String(t)));
}

function seriesOf(line: Line): uPlot.Series {
  const base = { stroke: line.colour, points: { show: false } };
  switch (line.look) {
    case "solid":
      return { ...base, width: 1.5 };
    case "dashed":
      return { ...base, width: 1.5, dash: [6, 4] };
    case "thin":
      return { ...base, width: 0.75, dash: [2, 2] };
    case "dots":
      return {
        stroke: line.colour,
        width: 0.75,
        points: { show: true, size: 4, fill: line.colour, filter: everyFewth },
      };
  }
}

/** Dots thin enough to be told apart; the hair line between them still shows every spike. */
function everyFewth(plot: uPlot, series: number): number[] {
  const values = plot.data[series];
  const dots: number[] = [];
  for (let i = 0; i < values.length; i += DOT_EVERY) if (typeof values[i] === "number") dots.push(i);
  return dots;
}
