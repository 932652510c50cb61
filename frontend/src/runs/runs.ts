import type { Preview, PreviewBody, RunBody, RunState } from "../api/types";
import { bodyOf, type DrawingState } from "../drawing/drawing";
import { quietly, type Shelf } from "../drawing/kept";
import { isSame, planInputs } from "../drawing/planner";
import type { Operations } from "../operate/operations";
import type { Page } from "../live/page";
import { Store } from "../ui/store";

export type Source = "library" | "drawing";

/** What would be run, how often, and what the twin says about it. */
export interface RunChoice {
  readonly source: Source;
  readonly laps: number;
  /** Until stopped, whatever `laps` says. */
  readonly endless: boolean;
  /** Each run gets a recording of its own, unless one is going on. */
  readonly record: boolean;
  readonly preview: Preview | null;
  readonly previewing: boolean;
  /** The result whose card was closed. */
  readonly dismissed: number | null;
}

export const FIRST_CHOICE: RunChoice = {
  source: "library",
  laps: 1,
  endless: false,
  record: true,
  preview: null,
  previewing: false,
  dismissed: null,
};

/** What previews and runs, so that tests can answer. */
export interface RunPort {
  preview(body: PreviewBody): Promise<Preview>;
  run(body: RunBody): Promise<RunState>;
  steerRun(step: "pause" | "resume" | "stop"): Promise<RunState>;
}

/** Previews and runs of what is chosen: the drawing, or a reference of the library. */
export class Runs {
  readonly store = new Store<RunChoice>(FIRST_CHOICE);
  private subject: readonly unknown[] = [];

  constructor(
    private readonly drawing: Store<DrawingState>,
    private readonly page: Store<Page>,
    private readonly port: RunPort,
    private readonly operations: Pick<Operations, "attempt">,
  ) {
    for (const { subscribe } of [drawing, page, this.store])
      subscribe(() => {
        this.forgetOldPreview();
      });
    this.forgetOldPreview();
  }

  choose(source: Source): void {
    this.store.patch({ source });
  }

  repeat(laps: number): void {
    this.store.patch({ laps });
  }

  /** What would be followed, null without any. */
  body(): Pick<RunBody, "drawing" | "reference"> | null {
    return subjectOf(this.store.get(), this.drawing.get(), this.page.get());
  }

  async preview(): Promise<void> {
    const body = this.body();
    if (!body) return;
    const subject = this.subject;
    this.store.patch({ previewing: true });
    await this.operations.attempt("No preview", async () => {
      const preview = await this.port.preview({ ...body, laps: 1 });
      if (this.subject === subject) this.store.patch({ preview });
    });
    this.store.patch({ previewing: false });
  }

  async run(): Promise<void> {
    const body = this.body();
    if (!body) return;
    const { endless, laps, record } = this.store.get();
    await this.take("Not run", () => this.port.run({ ...body, laps: endless ? null : laps, record }));
  }

  async steer(step: "pause" | "resume" | "stop"): Promise<void> {
    await this.take(`Run not ${STEERED[step]}`, () => this.port.steerRun(step));
  }

  /** The server's answer counts before its next status comes. */
  private async take(title: string, ask: () => Promise<RunState>): Promise<void> {
    await this.operations.attempt(title, async () => {
      this.page.patch({ run: await ask() });
    });
  }

  /** A prediction of something else is worth nothing. */
  private forgetOldPreview(): void {
    const choice = this.store.get();
    const page = this.page.get();
    const subject = [choice.source, page.chosen, page.settings, ...planInputs(this.drawing.get(), page)];
    if (isSame(subject, this.subject)) return;
    this.subject = subject;
    this.store.patch({ preview: null });
  }
}

const RECORD = "tendril-record-runs";

/** The switch "record each run" as it was on the last visit, and kept from now on. */
export function keepRecord(runs: Runs, shelf: Pick<Shelf, "getItem" | "setItem">): void {
  quietly(() => {
    if (shelf.getItem(RECORD) === "off") runs.store.patch({ record: false });
  });
  runs.store.subscribe(() => {
    quietly(() => {
      shelf.setItem(RECORD, runs.store.get().record ? "on" : "off");
    });
  });
}

const STEERED = { pause: "paused", resume: "resumed", stop: "stopped" } as const;

function subjectOf(
  { source }: RunChoice,
  drawing: DrawingState,
  page: Page,
): Pick<RunBody, "drawing" | "reference"> | null {
  if (source === "library") return page.chosen === null ? null : { drawing: null, reference: page.chosen };
  const body = bodyOf(drawing);
  return body && { drawing: body, reference: null };
}

/** A run that has not ended. */
export function isUnderWay(run: RunState | null): run is RunState {
  return run !== null && (run.state === "approach" || run.state === "running" || run.state === "paused");
}
