import type uPlot from "uplot";
import type { RecordingState } from "../../api/types";
import type { Ink } from "../../ui/colours";

/** A place on the time axis that someone marked, in the x of the plot. */
export interface PlotMark {
  readonly at: number;
  readonly text: string;
}

export const NO_MARKS: readonly PlotMark[] = [];
/** How far from its line a mark is still hit [px]. */
const REACH_PX = 6;

/** The bookmarks of the running recording on the rig's clock, as the page's state has them. */
export function liveMarks({
  origin,
  bookmarks,
}: Pick<RecordingState, "origin" | "bookmarks">): readonly PlotMark[] {
  return bookmarks.map(({ n, t, label }) => ({ at: origin + t, text: label === "" ? String(n) : label }));
}

/** Vertical lines with their texts at the top, for a plot's `draw`; x counts from `origin`. */
export function drawMarks(plot: uPlot, marks: readonly PlotMark[], ink: Ink, origin = 0): void {
  const { ctx, bbox } = plot;
  const { min = 0, max = 0 } = plot.scales.x;
  ctx.save();
  ctx.fillStyle = ink.text;
  ctx.textAlign = "left";
  ctx.textBaseline = "alphabetic";
  ctx.font = `600 ${10 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  const inside = marks.filter(({ at }) => at - origin >= min && at - origin <= max);
  const lines = inside.map(({ at }) => Math.round(plot.valToPos(at - origin, "x", true)));
  const measure = (text: string) => ctx.measureText(text).width;
  for (const [i, { text }] of inside.entries()) {
    const x = lines[i] ?? 0;
    const end = Math.min(bbox.left + bbox.width, ...lines.filter((line) => line > x));
    const shown = cutTo(end - x - 6 * devicePixelRatio, text, measure);
    ctx.strokeStyle = ink.text;
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([devicePixelRatio, 3 * devicePixelRatio]);
    ctx.beginPath();
    const middle = x + devicePixelRatio / 2; // of a whole pixel: between two it would be of half the ink in both
    ctx.moveTo(middle, bbox.top);
    ctx.lineTo(middle, bbox.top + bbox.height);
    ctx.stroke();
    ctx.strokeStyle = ink.paper; // a seam, so that it is read over the curves
    ctx.lineWidth = 4 * devicePixelRatio;
    ctx.setLineDash([]);
    const place = [x + 4 * devicePixelRatio, bbox.top + 10 * devicePixelRatio] as const;
    ctx.strokeText(shown, ...place);
    ctx.fillText(shown, ...place);
  }
  ctx.restore();
}

/** As much of `text` as is at most `room` wide, with dots where it is cut; "" where not even its first letter fits. */
export function cutTo(room: number, text: string, measure: (text: string) => number): string {
  const width = measure(text);
  if (width <= room) return text;
  const letters = Array.from(text);
  for (let kept = Math.floor((letters.length * room) / width); kept > 0; kept -= 1) {
    const cut = `${letters.slice(0, kept).join("").trimEnd()}…`;
    if (measure(cut) <= room) return cut;
  }
  return "";
}

/** The mark whose line is under `px` of the plot's area; null for none. */
export function markAt(plot: uPlot, marks: readonly PlotMark[], px: number, origin = 0): PlotMark | null {
  const off = (mark: PlotMark) => Math.abs(plot.valToPos(mark.at - origin, "x") - px);
  const near = marks.filter((mark) => off(mark) <= REACH_PX).sort((a, b) => off(a) - off(b));
  return near.at(0) ?? null;
}
