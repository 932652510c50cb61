import type { PlotBins } from "../api/binary";

/** The last `capacity` plot bins of every channel, in arrays made once. Bin 0 is the oldest. */
export class Ring {
  private readonly t: Float64Array;
  private readonly low: Float32Array;
  private readonly high: Float32Array;
  private first = 0;
  private count = 0;

  constructor(
    readonly channels: number,
    readonly capacity: number,
  ) {
    this.t = new Float64Array(capacity);
    this.low = new Float32Array(capacity * channels);
    this.high = new Float32Array(capacity * channels);
  }

  get length(): number {
    return this.count;
  }

  /** Time of the newest bin [s on the rig's clock], nan when empty. */
  get newest(): number {
    return this.count === 0 ? NaN : this.time(this.count - 1);
  }

  clear(): void {
    this.first = this.count = 0;
  }

  /** Append the bins that are newer than the newest one: history is sent again after a reconnection. */
  push(bins: PlotBins): void {
    if (bins.low.length !== bins.t.length * this.channels) return;
    for (let bin = 0; bin < bins.t.length; bin++) if (!(bins.t[bin] <= this.newest)) this.append(bins, bin);
  }

  time(bin: number): number {
    return this.t[this.slot(bin)];
  }

  lowest(bin: number, channel: number): number {
    return this.low[this.slot(bin) * this.channels + channel];
  }

  highest(bin: number, channel: number): number {
    return this.high[this.slot(bin) * this.channels + channel];
  }

  /** First bin at or after time `t`; `length` if there is none. */
  indexAt(t: number): number {
    let [low, high] = [0, this.count];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < t) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  private slot(bin: number): number {
    return (this.first + bin) % this.capacity;
  }

  private append(bins: PlotBins, bin: number): void {
    if (this.count === this.capacity) this.first = (this.first + 1) % this.capacity;
    else this.count += 1;
    const slot = this.slot(this.count - 1);
    this.t[slot] = bins.t[bin];
    for (let channel = 0; channel < this.channels; channel++) {
      this.low[slot * this.channels + channel] = bins.low[bin * this.channels + channel];
      this.high[slot * this.channels + channel] = bins.high[bin * this.channels + channel];
    }
  }
}
