import type { PlotBins } from "../api/socket";

interface Column {
  readonly low: Float32Array;
  readonly high: Float32Array;
  /** False until anything came: its past is still to be asked for. */
  filled: boolean;
}

/**
 * The last `capacity` plot bins of the chosen channels, in arrays made once per channel. Bin 0 is the oldest.
 * The past of a channel chosen later comes later, so bins are placed by the server's numbers.
 */
export class Ring {
  private readonly t: Float64Array;
  private readonly columns = new Map<number, Column>();
  /** Own numbers of the oldest bin and of the next one, never so small that the past could make them negative. */
  private begin: number;
  private end: number;
  /** Own minus server's number, nan when not known. */
  private shift = NaN;
  /** Rises when bins change that were there before. */
  version = 0;

  constructor(readonly capacity: number) {
    this.t = new Float64Array(capacity);
    this.begin = this.end = capacity;
  }

  get length(): number {
    return this.end - this.begin;
  }

  /** Time of the newest bin [s on the rig's clock], nan when empty. */
  get newest(): number {
    return this.length === 0 ? NaN : this.time(this.length - 1);
  }

  /** The newest time up to which every channel is here; null when the server must send everything. */
  get since(): number | null {
    const whole = this.length > 0 && [...this.columns.values()].every((column) => column.filled);
    return whole ? this.newest : null;
  }

  clear(): void {
    this.begin = this.end;
    this.version += 1;
    this.shift = NaN;
    for (const column of this.columns.values()) column.filled = false;
  }

  /** The server's numbers may be others from now on; where it must send everything, nothing old is in the way. */
  reconnect(): void {
    if (this.since === null) this.clear();
    this.shift = NaN;
  }

  /** Hold these channels and no others. */
  choose(channels: readonly number[]): void {
    for (const channel of this.columns.keys()) if (!channels.includes(channel)) this.columns.delete(channel);
    for (const channel of channels) if (!this.columns.has(channel)) this.columns.set(channel, this.made());
  }

  /** Take bins: newer ones are appended, known ones get the values of the channels that come with them. */
  push(bins: PlotBins): void {
    if (bins.t.length === 0) return;
    const first = this.numberOf(bins);
    if (first < this.end) this.version += 1;
    for (let i = 0; i < bins.t.length; i++) if (first + i >= this.end) this.append(bins.t[i]);
    for (let i = this.begin - first - 1; i >= 0 && this.length < this.capacity; i--) this.prepend(bins.t[i]);
    bins.channels.forEach((channel, place) => {
      const column = this.columns.get(channel);
      if (column) this.fill(column, bins, place, first);
    });
  }

  time(bin: number): number {
    return this.t[(this.begin + bin) % this.capacity];
  }

  /** Lowest and highest value of a channel in the bins [from, to); [inf, -inf] where there is none. */
  extremes(channel: number, from: number, to: number): [number, number] {
    let [lowest, highest] = [Infinity, -Infinity];
    const column = this.columns.get(channel);
    if (!column) return [lowest, highest];
    for (let bin = from; bin < to; bin++) {
      const slot = (this.begin + bin) % this.capacity;
      const [low, high] = [column.low[slot], column.high[slot]];
      if (low < lowest) lowest = low;
      if (high > highest) highest = high;
    }
    return [lowest, highest];
  }

  /** First bin at or after time `t`; `length` if there is none. */
  indexAt(t: number): number {
    let [low, high] = [0, this.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < t) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  private made(): Column {
    const nan = () => new Float32Array(this.capacity).fill(NaN);
    return { low: nan(), high: nan(), filled: false };
  }

  /** Own number of the first of `bins`. After a reconnection times tell which bins are the same. */
  private numberOf(bins: PlotBins): number {
    if (Number.isNaN(this.shift)) {
      const newer = bins.t.findIndex((t) => !(t <= this.newest));
      const last = bins.t.length - 1;
      this.shift =
        newer >= 0
          ? this.end - (bins.first + newer)
          : this.begin + this.indexAt(bins.t[last]) - (bins.first + last);
    }
    // Bins that never came leave no gap in the numbers, only in the times.
    this.shift = Math.min(this.shift, this.end - bins.first);
    return bins.first + this.shift;
  }

  private append(t: number): void {
    if (this.length === this.capacity) this.begin += 1;
    this.end += 1;
    this.empty(this.end - 1, t);
  }

  private prepend(t: number): void {
    this.begin -= 1;
    this.empty(this.begin, t);
  }

  /** A bin without values. */
  private empty(bin: number, t: number): void {
    const slot = bin % this.capacity;
    this.t[slot] = t;
    for (const { low, high } of this.columns.values()) low[slot] = high[slot] = NaN;
  }

  private fill(column: Column, bins: PlotBins, place: number, first: number): void {
    const width = bins.channels.length;
    column.filled = true;
    for (let i = Math.max(0, this.begin - first); i < bins.t.length; i++) {
      const slot = (first + i) % this.capacity;
      column.low[slot] = bins.low[i * width + place];
      column.high[slot] = bins.high[i * width + place];
    }
  }
}
