import type { Point, RunState } from "../api/types";
import type { Live } from "../live/live";
import type { Page } from "../live/page";
import { Store } from "../ui/store";

/** Where the tip was measured in the last run [m], leg by leg: what a pause parts is not joined. */
export interface Trace {
  readonly run: number | null;
  readonly legs: readonly (readonly Point[])[];
}

const NONE: Trace = { run: null, legs: [] };
/** Nearer than this to the last point is none of its own [m]. */
const STEP_M = 0.0003;
/** More points in a leg are thinned to half of them: hours of laps lie on one another. */
const POINTS_MAX = 8000;
/** After so long without a new frame (the tab was hidden, the link gone) no one knows the way between [ms]. */
const GAP_MS = 500;
/** How often what has been added is shown [ms]. */
const SHOWN_MS = 200;

/** Keeps the measured path of the last run, until it is cleared or another run begins. */
export class RunTrace {
  readonly store = new Store<Trace>(NONE);
  private legs: Point[][] = [];
  private running = false;
  private tick = NaN;
  private addedAt = NaN;
  private shownAt = -Infinity;

  constructor(
    private readonly live: Pick<Live, "telemetry">,
    private readonly page: Store<Page>,
  ) {}

  /** Look at the newest frame, at page time `now` [ms]. */
  look(now: number): void {
    const { run } = this.page.get();
    if (run && run.id !== this.store.get().run && isMoving(run)) this.begin(run.id);
    const running = run?.state === "running" && run.id === this.store.get().run;
    if (running && !this.running) this.legs.push([]);
    const ended = this.running && !running;
    this.running = running;
    if (running) this.add(now);
    if (ended || (running && now - this.shownAt >= SHOWN_MS)) this.show(now);
  }

  clear(): void {
    this.legs = this.running ? [[]] : [];
    this.store.patch({ legs: [] });
  }

  private begin(run: number): void {
    this.legs = [];
    this.running = false;
    this.store.patch({ run, legs: [] });
  }

  private add(now: number): void {
    const { telemetry } = this.live;
    const tip = telemetry?.point("p_meas");
    if (!telemetry || !tip || telemetry.at("tick") === this.tick) return;
    this.tick = telemetry.at("tick");
    const leg = this.legNow(now);
    const last = leg.at(-1);
    if (last && Math.hypot(tip[0] - last[0], tip[1] - last[1]) < STEP_M) return;
    leg.push([tip[0], tip[1]]);
    if (leg.length > POINTS_MAX) leg.splice(0, leg.length, ...leg.filter((_, i) => i % 2 === 0));
  }

  /** The leg that goes on at page time `now`. */
  private legNow(now: number): Point[] {
    const leg = this.legs.at(-1);
    const isBroken = now - this.addedAt > GAP_MS;
    this.addedAt = now;
    if (leg && !(isBroken && leg.length > 0)) return leg;
    const next: Point[] = [];
    this.legs.push(next);
    return next;
  }

  private show(now: number): void {
    this.shownAt = now;
    this.store.patch({ legs: this.legs.map((leg) => [...leg]) });
  }
}

function isMoving({ state }: RunState): boolean {
  return state === "approach" || state === "running";
}
