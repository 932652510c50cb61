import { api } from "../../api/rest";
import type { Page } from "../../live/page";
import type { Store } from "../../ui/store";
import type { Operations } from "../operations";
import { isPaused } from "../permission";

/** Lengths of a step [ticks]. */
export const STEP_LENGTHS = [1, 10, 100, 1000] as const;

/** A step that follows another so soon is taken, though the page has not heard yet that the twin stands again [ms]. */
const STEPPING_MS = 500;

/** The twin's time: paused, going on, or going on by steps. Keys do here what the buttons do. */
export class TwinTime {
  /** Page clock [ms] of the last step: while it is taken the twin does not stand still. */
  private steppedAt = -Infinity;

  constructor(
    private readonly page: Store<Page>,
    private readonly operations: Operations,
  ) {}

  /** Pause, or let it go on. */
  async toggle(): Promise<void> {
    if (this.operations.whyNot("time") !== null) return;
    const paused = !isPaused(this.page.get());
    await this.put(paused ? "Not paused" : "Not continued", { paused, steps: 0 });
  }

  /** Take the chosen number of ticks and stand again; nothing while it is not paused. */
  async step(): Promise<void> {
    const steps = performance.now() - this.steppedAt < STEPPING_MS;
    if (this.operations.whyNot("time") !== null || !(steps || isPaused(this.page.get()))) return;
    this.steppedAt = performance.now();
    await this.put("No step taken", { paused: true, steps: this.page.get().step });
  }

  private async put(title: string, body: { paused: boolean; steps: number }): Promise<void> {
    await this.operations.attempt(title, () => api.PUT("/api/twin/time", { body }));
  }
}
