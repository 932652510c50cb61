import { api, dataOf } from "../api/rest";
import type { DrawingBody } from "../api/types";
import type { Page } from "../live/page";
import { textOf } from "../ui/format";
import type { Store } from "../ui/store";
import { bodyOf, sketchOf, type DrawingState } from "./drawing";

/** Who plans, and the clock: tests have others. */
const server = {
  plan: (body: DrawingBody) => dataOf(api.POST("/api/drawings/plan", { body })),
  later: (action: () => void, delay: number): unknown => setTimeout(action, delay),
};

const QUIET_MS = 150;

/** Keeps the server's word about the drawing up to date: asks once it has rested, and drops answers that came late. */
export class Planner {
  private wanted: readonly unknown[] = [];
  private asked = 0;

  constructor(
    private readonly drawing: Store<DrawingState>,
    private readonly page: Store<Page>,
    private readonly port = server,
  ) {
    drawing.subscribe(() => {
      this.look();
    });
    page.subscribe(() => {
      this.look();
    });
  }

  /** Ask again when the drawing, the rig or its limits have changed. */
  private look(): void {
    const inputs = planInputs(this.drawing.get(), this.page.get());
    if (isSame(inputs, this.wanted)) return;
    this.wanted = inputs;
    if (this.drawing.get().planOf !== null) this.drawing.patch({ planOf: null }); // nothing is run by the old plan
    this.asked += 1;
    const number = this.asked;
    this.port.later(() => {
      if (number === this.asked) void this.ask(number);
    }, QUIET_MS);
  }

  private async ask(number: number): Promise<void> {
    const body = bodyOf(this.drawing.get());
    const planOf = sketchOf(this.drawing.get()).pieces;
    try {
      const plan = body && this.page.get().rig && (await this.port.plan(body));
      if (number === this.asked) this.drawing.patch({ plan, planOf, problem: "" });
    } catch (error) {
      const problem = textOf(error);
      if (number === this.asked) this.drawing.patch({ plan: null, problem });
    }
  }
}

/** Everything that a plan depends on: values, and objects that are replaced when they change. */
export function planInputs(drawing: DrawingState, { rig, settings }: Page): readonly unknown[] {
  const { pieces, closed } = sketchOf(drawing);
  return [pieces, closed, drawing.manner, rig?.boot, settings?.speed_max, settings?.acceleration_max];
}

export function isSame(a: readonly unknown[], b: readonly unknown[]): boolean {
  return a.length === b.length && a.every((value, i) => Object.is(value, b[i]));
}
