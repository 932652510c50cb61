import { decodeBinary } from "../api/socket";
import type { Field, PlotChannel, PlotChoice } from "../api/types";
import { Telemetry } from "./telemetry";
import { Store } from "../ui/store";
import { keep } from "./page";
import { Ring } from "./ring";
import { Trail } from "./trail";

/** Ten minutes of the server's 16 ms bins. */
const BINS_KEPT = 37_500;
/** Most channels that the server sends one page. */
const CHANNELS_MAX = 48;

/** The stream: written by the socket at up to 60 Hz, read by painters. Nothing here makes React render. */
export class Live {
  telemetry: Telemetry | null = null;
  /** What can be plotted, from the server. */
  readonly signals = new Store<{ readonly channels: readonly PlotChannel[] }>({ channels: [] });
  readonly ring = new Ring(BINS_KEPT);
  readonly trail = new Trail();
  /** Page clock [ms] when a tick newer than the one before arrived. */
  freshAt = -Infinity;
  /** Rises with every frame: painters compare it with what they painted. */
  frames = 0;
  readonly roundTrip = new RoundTrip();
  private tick = NaN;
  private plotted: readonly string[] = [];

  /** A new connection: the layout may have changed, the history stays where it fits. */
  describe(layout: readonly Field[], channels: readonly PlotChannel[]): void {
    this.telemetry = new Telemetry(layout);
    const before = this.signals.get().channels;
    if (keep(before, channels) !== before) this.ring.clear();
    this.signals.patch({ channels: keep(before, channels) });
    this.ring.reconnect();
  }

  /** Show these channels (keys) from now on; what the server should be told. Keys it does not know are left out. */
  plot(keys: readonly string[]): PlotChoice {
    this.plotted = keys;
    return this.choice();
  }

  /** What the server should be told at the start of a connection. */
  choice(): PlotChoice {
    const { channels } = this.signals.get();
    const places = [...new Set(this.plotted)].map((key) => channels.findIndex((item) => item.key === key));
    const known = places.filter((place) => place >= 0).slice(0, CHANNELS_MAX);
    this.ring.choose(known);
    return { type: "plots", channels: known.map((place) => channels[place].key), since: this.ring.since };
  }

  /** The rig lives again: its clock and counters say nothing about the ones before. */
  forget(): void {
    this.ring.clear();
    this.trail.clear();
  }

  /** Take a binary message at page time `now` [ms]; true if it was a telemetry frame. */
  take(buffer: ArrayBuffer, now: number): boolean {
    const message = decodeBinary(buffer);
    if (message.kind === "plot") this.ring.push(message.bins);
    else if (this.telemetry) this.takeFrame(this.telemetry, buffer, message.offset, now);
    return message.kind === "frame";
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
  }
}

/** Page -> server -> page. An answer that is owed for longer than the last one took counts more than that. */
export class RoundTrip {
  /** What the last answer took [s], nan before the first. */
  took = NaN;
  /** Page clock [ms] when the oldest ping without an answer was sent. */
  private owedSince: number | null = null;

  sent(now: number): void {
    this.owedSince ??= now;
  }

  /** The ping of `sent` is answered, and with it all before. */
  answered(sent: number, now: number): void {
    this.took = (now - sent) / 1e3;
    this.owedSince = null;
  }

  /** The connection is gone: so is what was known. */
  forget(): void {
    this.took = NaN;
    this.owedSince = null;
  }

  /** As it stands at page time `now` [ms], in s; nan before the first answer. */
  at(now = performance.now()): number {
    return this.owedSince === null ? this.took : Math.max(this.took, (now - this.owedSince) / 1e3);
  }
}
