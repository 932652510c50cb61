import uPlot from "uplot";
import type { Ring } from "../../live/ring";
import { FONT, type Ink } from "../../ui/colours";
import { DASH, plain } from "../../ui/format";
import type { Painter } from "../../ui/painters";
import { digitsFor, numberLabels, secondsTicks, SIDES, SPACE, timeLabel, type Marked } from "./axes";
import type { Chart, Line } from "./charts";
import { Gestures } from "./gestures";
import { drawMarks, markAt, NO_MARKS, type PlotMark } from "./marks";
import { Readout, write, type TimeCursor } from "./readout";
import type { Gesture, Range } from "./view";
import { emptyData, extractWindow, niceRange, type PlotData } from "./window";

const DOT_EVERY = 6;
const PX_PER_COLUMN = 2;
const SELECTED_PX = 4;
/** A picture that follows the rig is painted again when it has moved by this time [s], or this part of its width. */
const STEP_S = 0.05;
const STEP_SHARE = 1e-3;

/** Where the newest values are written, beside a chart's title: one element per line, or null. */
export type Legend = readonly (HTMLElement | null)[];

/** One uPlot chart that follows the ring without React. */
export class ChartPainter implements Painter {
  readonly name: string;
  /** Any of it is in sight: not scrolled away, nor behind the review. */
  seen = true;
  private readonly plot: uPlot;
  private readonly data: PlotData;
  private readonly readout: Readout;
  private readonly gestures: Gestures;
  private range: [number, number] = [0, 1];
  private shown: Range = { from: -10, to: 0 };
  private origin = 0;
  private version = -1;
  private marks = NO_MARKS;

  constructor(
    private readonly chart: Chart,
    host: HTMLElement,
    private readonly legend: Legend,
    private ink: Ink,
    private readonly cursor: TimeCursor,
    private readonly onGesture: (gesture: Gesture) => void,
  ) {
    this.name = `plot of ${chart.title}`;
    this.data = emptyData(chart.lines.length);
    this.readout = new Readout(chart, host);
    this.plot = new uPlot(this.options(host), this.columns(), host);
    this.gestures = new Gestures(this.plot.over, (px) => this.timeAt(px), onGesture);
    this.plot.over.addEventListener("click", (event) => this.seek(event.offsetX));
  }

  destroy(): void {
    this.gestures.destroy();
    this.readout.destroy();
    this.plot.destroy();
  }

  resize(width: number, height: number): void {
    if (width > 0 && height > 0) this.plot.setSize({ width, height });
  }

  useInk(ink: Ink): void {
    this.ink = ink;
    this.plot.redraw(false, true);
  }

  /** Show a stretch of time if that changes the picture; x counts from `origin` [s on the rig's clock], as `marks` do not. */
  follow(ring: Ring, range: Range, origin: number, marks: readonly PlotMark[]): boolean {
    const width = range.to - range.from;
    const step = Math.max(STEP_S, width * STEP_SHARE);
    const [from, to] = [range.from - this.origin - this.shown.from, range.to - this.origin - this.shown.to];
    const stands = Math.abs(to) < step && Math.abs(from) < step && Math.abs(to - from) < 1e-9 * width;
    if (stands && this.version === ring.version && this.marks === marks) return false;
    this.marks = marks;
    this.show(ring, range, origin);
    this.version = ring.version;
    return true;
  }

  private show(ring: Ring, range: Range, origin: number): void {
    const columns = Math.max(20, Math.round(this.plot.width / PX_PER_COLUMN));
    this.shown = { from: range.from - origin, to: range.to - origin };
    this.origin = origin;
    const channels = this.chart.lines.map((line) => line.channel);
    extractWindow(ring, channels, { ...range, origin, columns }, this.chart.scale, this.data);
    this.range = niceRange(this.data, this.chart.least, this.chart.fromZero);
    this.plot.setData(this.columns());
    this.read();
  }

  /** Write the newest values beside the title. */
  writeValues(): void {
    const digits = digitsFor(this.range);
    this.legend.forEach((element, i) => {
      if (element) write(element, plain(this.data.series[i].at(-1), digits));
    });
  }

  private columns(): uPlot.AlignedData {
    return [this.data.x, ...this.data.series];
  }

  private timeAt(px: number): number {
    return this.origin + this.plot.posToVal(px, "x");
  }

  /** Show what lies under the cursor. */
  private read(): void {
    const at = this.plot.cursor.idx;
    const left = this.plot.cursor.left ?? -1;
    if (at === null || at === undefined || left < 0) {
      this.readout.hide();
      this.cursor.hide();
      return;
    }
    this.readout.show({
      values: this.data.series.map((series) => valueAt(series, at, digitsFor(this.range))),
      left: left > plotWidth(this.plot) / 2,
    });
    this.cursor.show(
      left / plotWidth(this.plot),
      timeLabel(this.data.x[at], digitsFor([this.shown.from, this.shown.to])),
    );
  }

  private options(host: HTMLElement): uPlot.Options {
    return {
      width: Math.max(50, host.clientWidth),
      height: Math.max(50, host.clientHeight),
      legend: { show: false },
      padding: PADDING,
      cursor: {
        sync: { key: "live", filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } },
        drag: { x: true, y: false, setScale: false },
        bind: { dblclick: () => () => null },
        y: false,
        points: { size: 5 },
      },
      scales: {
        x: { time: false, range: () => [this.shown.from, this.shown.to] },
        y: { range: () => this.range },
      },
      axes: axesOf(() => this.ink, secondsTicks),
      series: [{}, ...this.chart.lines.map(seriesOf)],
      hooks: {
        setCursor: [
          () => {
            this.read();
          },
        ],
        setSelect: [
          () => {
            this.select();
          },
        ],
        draw: [
          () => {
            this.drawNames();
            drawMarks(this.plot, this.marks, this.ink, this.origin);
          },
        ],
      },
    };
  }

  /** Stop where a bookmark's line was clicked, with it in the middle. */
  private seek(px: number): void {
    const mark = markAt(this.plot, this.marks, px, this.origin);
    const half = (this.shown.to - this.shown.from) / 2;
    if (mark) this.onGesture({ kind: "zoom", from: mark.at - half, to: mark.at + half });
  }

  private select(): void {
    const { left, width } = this.plot.select;
    if (width === 0) return;
    this.plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    if (width >= SELECTED_PX)
      this.onGesture({ kind: "zoom", from: this.timeAt(left), to: this.timeAt(left + width) });
  }

  private drawNames(): void {
    const { ctx, bbox } = this.plot;
    ctx.save();
    ctx.font = `${10 * devicePixelRatio}px ${FONT}`;
    ctx.textAlign = "right";
    let taken = Infinity;
    for (const { tag, colour, y } of this.lineEnds()) {
      const at = Math.min(y, taken - 10 * devicePixelRatio);
      taken = at;
      ctx.fillStyle = colour;
      ctx.fillText(tag, bbox.left + bbox.width - 3, at - 2);
    }
    ctx.restore();
  }

  /** Named lines from the lowest on the screen to the highest. */
  private lineEnds(): { tag: string; colour: string; y: number }[] {
    return this.chart.lines
      .flatMap((line, i) => {
        const value = this.data.series[i].at(-1);
        if (!line.named || typeof value !== "number") return [];
        return [{ tag: line.tag, colour: line.colour, y: this.plot.valToPos(value, "y", true) }];
      })
      .sort((a, b) => b.y - a.y);
  }
}

/** Above the curves half a label of y, as below: what time it is stands on an axis of its own. */
export const PADDING: uPlot.Padding = [6, SIDES.right, 6, 0];

/** How wide the curves' own area is [px]. */
export function plotWidth({ width }: uPlot): number {
  return width - SIDES.left - SIDES.right;
}

/** Grid lines on the marks of the time axis below, which are not written here; and y with its labels. */
export function axesOf(ink: () => Ink, marked: Marked): uPlot.Axis[] {
  const base: uPlot.Axis = {
    gap: 2,
    font: `10px ${FONT}`,
    stroke: () => ink().soft,
    grid: { stroke: () => ink().gridMajor, width: 1 },
    ticks: { show: false },
    space: SPACE,
  };
  const places = (plot: uPlot, _axis: number, from: number, to: number) =>
    marked({ from, to }, plotWidth(plot)).map(({ at }) => at);
  return [
    { ...base, size: 0, splits: places, values: (_plot, splits) => splits.map(() => "") },
    { ...base, size: SIDES.left, values: (_plot, splits) => numberLabels(splits) },
  ];
}

/** The value at a point; where its column holds several that differ, the lowest and the highest. */
function valueAt(series: readonly (number | null)[], at: number, digits: number): string {
  const texts = [series[at], series[at ^ 1]]
    .filter((value) => typeof value === "number")
    .sort((a, b) => a - b)
    .map((value) => plain(value, digits));
  if (texts.length === 0) return DASH;
  return texts[0] === texts.at(-1) ? texts[0] : texts.join(" … ");
}

/** How uPlot draws a line of this look. */
export function seriesOf(line: Line): uPlot.Series {
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
