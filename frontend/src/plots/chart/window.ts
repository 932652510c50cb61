import type { Ring } from "../../live/ring";
import { niceStep } from "./axes";

/** Samples of one plot as uPlot takes them: a shared x [s after the span's origin] and one y per series, null = gap. */
export interface PlotData {
  readonly x: number[];
  readonly series: (number | null)[][];
}

export interface Span {
  readonly from: number;
  readonly to: number;
  /** Where x is 0 [s on the rig's clock, like `from` and `to`]. */
  readonly origin: number;
  readonly columns: number;
}

/** Time without bins that is shown as a gap [s]: several times as long as a bin. */
const GAP_S = 0.1;

/** Empty data with room for `series` series. */
export function emptyData(series: number): PlotData {
  return { x: [], series: Array.from({ length: series }, () => []) };
}

/**
 * Fill `out` with the extremes per column of the time span, two points a column, so that no spike is lost.
 * Columns lie on a fixed time grid: a scrolling picture does not shimmer. `scale` makes display units.
 */
export function extractWindow(
  ring: Ring,
  channels: readonly number[],
  span: Span,
  scale: number,
  out: PlotData,
): void {
  const width = (span.to - span.from) / span.columns;
  out.x.length = 0;
  for (const series of out.series) series.length = 0;
  let bin = ring.indexAt(span.from);
  const end = ring.indexAt(span.to + width);
  while (bin < end) {
    const column = Math.floor(ring.time(bin) / width);
    let next = bin + 1;
    while (next < end && Math.floor(ring.time(next) / width) === column) next += 1;
    const centre = (column + 0.5) * width - span.origin;
    out.x.push(centre - width / 4, centre + width / 4);
    for (let s = 0; s < channels.length; s++)
      pushExtremes(ring, channels[s], bin, next, scale, out.series[s]);
    if (next < end && ring.time(next) - ring.time(next - 1) > Math.max(GAP_S, 2 * width)) {
      out.x.push(centre + 0.5 * width, centre + 0.6 * width);
      for (const series of out.series) series.push(null, null);
    }
    bin = next;
  }
}

/** Rising signals show the low end first, falling ones the high end: else a ramp would look like a saw. */
function pushExtremes(
  ring: Ring,
  channel: number,
  from: number,
  to: number,
  scale: number,
  y: (number | null)[],
): void {
  const [low, high] = ring.extremes(channel, from, to);
  if (!Number.isFinite(high - low)) {
    y.push(null, null);
    return;
  }
  const before = y.at(-1) ?? low * scale;
  const rising = (low + high) * scale >= 2 * before;
  if (rising) y.push(low * scale, high * scale);
  else y.push(high * scale, low * scale);
}

/** Limits around the data, at least `least` wide, on a round grid: the axis stands still while the data moves. */
export function niceRange(data: PlotData, least: number, fromZero: boolean): [number, number] {
  let [low, high] = fromZero ? [0, 0] : [Infinity, -Infinity];
  for (const series of data.series)
    for (const y of series)
      if (y !== null) {
        low = Math.min(low, y);
        high = Math.max(high, y);
      }
  if (low > high) [low, high] = [0, 0];
  const middle = (low + high) / 2;
  if (high - low < least) [low, high] = fromZero ? [0, least] : [middle - least / 2, middle + least / 2];
  const step = niceStep((high - low) / 4);
  return [Math.floor(low / step) * step, Math.ceil(high / step) * step];
}
