import type { Preview, PreviewBody, RecordingState, RunBody, RunState } from "../api/types";
import { bodyOf, type DrawingState } from "./drawing";
import { isSame, planInputs } from "./drawingPlan";
import type { Operations } from "./operations";
import type { Page } from "./page";
import { Store } from "./store";

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
  startRecording(name: string): Promise<RecordingState>;
  stopRecording(): Promise<unknown>;
}

/** Previews and runs of what is chosen: the drawing, or a reference of the library. */
export class Runs {
  readonly store = new Store<RunChoice>(FIRST_CHOICE);
  /** The recording begun for the run under way. */
  private recording: string | null = null;
  private underWay = false;
  private subject: readonly unknown[] = [];

  constructor(
    private readonly drawing: Store<DrawingState>,
    private readonly page: Store<Page>,
    private readonly port: RunPort,
    private readonly operations: Pick<Operations, "attempt">,
  ) {
    page.subscribe(() => {
      this.watchRun();
    });
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
    const { endless, laps } = this.store.get();
    await this.startRecording(body.drawing?.name ?? body.reference ?? "");
    await this.take("Not run", () => this.port.run({ ...body, laps: endless ? null : laps }));
    if (!isUnderWay(this.page.get().run)) await this.stopRecording();
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

  private async startRecording(name: string): Promise<void> {
    if (!this.store.get().record || this.page.get().recording.recording) return;
    await this.operations.attempt("Run not recorded", async () => {
      const recording = await this.port.startRecording(name);
      this.page.patch({ recording });
      this.recording = recording.id;
    });
  }

  /** End the recording that was begun for the run. */
  private async stopRecording(): Promise<void> {
    const { recording } = this.page.get();
    const ours = recording.recording && recording.id === this.recording;
    this.recording = null;
    if (ours) await this.operations.attempt("Recording not stopped", () => this.port.stopRecording());
  }

  /** When the run that was recorded has ended, so has its recording. */
  private watchRun(): void {
    const { run } = this.page.get();
    const underWay = isUnderWay(run);
    if (this.underWay && !underWay && this.recording !== null) void this.stopRecording();
    this.underWay = underWay;
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
