import { decodeBinary, type PlotBins } from "../api/binary";
import type { PlotChannel, Field } from "../api/types";
import { Ring } from "../plots/ring";
import { OnTime } from "./ontime";
import { Telemetry } from "./telemetry";
import { Trail } from "./trail";

/** Ten minutes at up to 100 bins a second. */
const BINS_KEPT = 60_000;

/** The stream: written by the socket at up to 60 Hz, read by painters. Nothing here makes React render. */
export class Live {
  telemetry: Telemetry | null = null;
  channels: readonly PlotChannel[] = [];
  ring = new Ring(0, 0);
  readonly trail = new Trail();
  readonly onTime = new OnTime();
  /** Page clock [ms] when a tick newer than the one before arrived. */
  freshAt = -Infinity;
  /** Rises with every frame: painters compare it with what they painted. */
  frames = 0;
  /** Round trip page -> server -> page [s]. */
  roundTrip = NaN;
  private tick = NaN;

  /** A new connection: the layout may have changed, the history stays where it fits. */
  describe(layout: readonly Field[], channels: readonly PlotChannel[]): void {
    this.telemetry = new Telemetry(layout);
    this.channels = channels;
    if (this.ring.channels !== channels.length) this.ring = new Ring(channels.length, BINS_KEPT);
  }

  /** The rig lives anew: its clock and counters say nothing about the ones before. */
  forget(): void {
    this.ring.clear();
    this.trail.clear();
    this.onTime.clear();
  }

  /** Take a binary message at page time `now` [ms]; true if it was a telemetry frame. */
  take(buffer: ArrayBuffer, now: number): boolean {
    const message = decodeBinary(buffer);
    if (message.kind === "plot") this.takeBins(message.bins);
    else if (this.telemetry) this.takeFrame(this.telemetry, buffer, message.offset, now);
    return message.kind === "frame";
  }

  private takeBins(bins: PlotBins): void {
    this.ring.push(bins);
  }

  private takeFrame(telemetry: Telemetry, buffer: ArrayBuffer, offset: number, now: number): void {
    telemetry.load(buffer, offset);
    this.frames += 1;
    const tick = telemetry.at("tick");
    if (tick === this.tick) return;
    this.tick = tick;
    this.freshAt = now;
    const tip = telemetry.point("p_meas") ?? telemetry.point("p_hat");
    if (tip) this.trail.push(tip[0], tip[1], now / 1e3);
    this.onTime.add(telemetry.at("slot"), telemetry.at("lost"), now / 1e3);
  }
}
