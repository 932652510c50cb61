import { jsonLines } from "../api/lines";
import { api, dataOf } from "../api/rest";
import type {
  ControllerInfo,
  LearnBody,
  Mode,
  Preview,
  PreviewBody,
  PreviewPart,
  ReferenceInfo,
  RunBody,
  RunState,
} from "../api/types";
import { bodyOf, isPlanned, sketchOf, type DrawingState } from "../drawing/drawing";
import { isSame, planInputs } from "../drawing/planner";
import type { Page } from "../live/page";
import type { Operations } from "../operate/operations";
import { useService } from "../ui/services";
import { quietly, type PageStorage } from "../ui/storage";
import { Store, useStore } from "../ui/store";

/** The predicted tip as far as it has been foreseen. */
export type Ghost = Pick<Preview, "approach" | "points" | "saturated" | "start">;

/** The error that was foreseen of a run [m]. */
export interface Foreseen {
  readonly run: number;
  readonly rmse: number;
}

/** What would be run, how often, and what the twin says about it. */
export interface RunChoice {
  readonly laps: number;
  /** Until stopped, whatever `laps` says. */
  readonly endless: boolean;
  /** Each run gets a recording of its own, unless one is going on. */
  readonly record: boolean;
  /** Once it has been foreseen to its end. */
  readonly preview: Preview | null;
  readonly ghost: Ghost | null;
  /** The rig's mode then: in any other one it may stand elsewhere, and its way to the path is another. */
  readonly foreseenIn: Mode | null;
  /** 0..1 of what is being foreseen. */
  readonly previewing: number | null;
  /** What the preview said of the run that followed it. */
  readonly foreseen: Foreseen | null;
  /** The result whose card was closed. */
  readonly dismissed: number | null;
}

export const FIRST_CHOICE: RunChoice = {
  laps: 1,
  endless: false,
  record: true,
  preview: null,
  ghost: null,
  foreseenIn: null,
  previewing: null,
  foreseen: null,
  dismissed: null,
};

/** So often a path is followed to learn it: most of what there is to learn comes in the first four. */
export const REPEATS = 8;

/** With what was learned of the path, if anything was. */
const USUAL = "frozen";

/** What previews and runs: the server, or a test. */
const server = {
  preview: foreseen,
  run: (body: RunBody) => dataOf(api.POST("/api/run", { body })),
  again: () => dataOf(api.POST("/api/run/again")),
  learn: (body: LearnBody) => dataOf(api.POST("/api/run/learn", { body })),
  forget: (key: string) => dataOf(api.DELETE("/api/learned/{key}", { params: { path: { key } } })),
  steer: (step: "pause" | "resume" | "stop") => dataOf(api.POST(`/api/run/${step}`)),
};

async function* foreseen(body: PreviewBody, signal: AbortSignal): AsyncGenerator<PreviewPart> {
  yield* jsonLines<PreviewPart>(
    await dataOf(api.POST("/api/preview/parts", { body, signal, parseAs: "stream" })),
  );
}

/** Previews and runs of what is chosen: the drawing, or a reference of the library. */
export class Runs {
  readonly store = new Store<RunChoice>(FIRST_CHOICE);
  private subject: readonly unknown[] = [];
  private asked: AbortController | null = null;

  constructor(
    private readonly drawing: Store<DrawingState>,
    private readonly page: Store<Page>,
    private readonly operations: Pick<Operations, "attempt">,
    private readonly port = server,
  ) {
    for (const { subscribe } of [drawing, page])
      subscribe(() => {
        this.forgetOldPreview();
      });
    this.forgetOldPreview();
  }

  repeat(laps: number): void {
    this.store.patch({ laps });
  }

  /** What would be followed, null without any. */
  body(): Pick<RunBody, "drawing" | "reference" | "K_FF"> | null {
    return subjectOf(this.drawing.get(), this.page.get());
  }

  async preview(): Promise<void> {
    const body = this.body();
    if (!body) return;
    this.cancelPreview();
    const { signal } = (this.asked = new AbortController());
    this.store.patch({ preview: null, ghost: null, foreseenIn: this.page.get().mode, previewing: 0 });
    await this.operations.attempt("No preview", () =>
      this.foresee({ ...body, laps: 1, learning: USUAL }, signal),
    );
    if (!signal.aborted) this.cancelPreview();
  }

  /** What has come so far is dropped as well: a piece of a run is no prediction of it. */
  cancelPreview(): void {
    this.asked?.abort();
    this.asked = null;
    const { preview } = this.store.get();
    this.store.patch({ previewing: null, ghost: preview });
  }

  private async foresee(body: PreviewBody, signal: AbortSignal): Promise<void> {
    try {
      for await (const part of this.port.preview(body, signal)) {
        if (signal.aborted) return;
        if (part.problem !== "") throw new Error(part.problem);
        const { preview, progress } = part;
        this.store.patch({
          preview,
          previewing: progress,
          ghost: preview ?? grown(this.store.get().ghost, part),
        });
      }
    } catch (error) {
      if (!signal.aborted) throw error;
    }
  }

  async run(): Promise<void> {
    const body = this.body();
    if (!body) return;
    const { endless, laps, record, preview } = this.store.get();
    const rmse = preview?.rmse ?? null;
    await this.take(
      "Not run",
      () => this.port.run({ ...body, laps: endless ? null : laps, record, learning: USUAL }),
      rmse,
    );
  }

  /** What was followed last, once more. */
  async again(): Promise<void> {
    const { foreseen } = this.store.get();
    const rmse = foreseen && foreseen.run === this.page.get().result?.id ? foreseen.rmse : null;
    await this.take("Not followed again", () => this.port.again(), rmse);
  }

  /** Repeat what would be run, and learn it. */
  async learn(): Promise<void> {
    const body = this.body();
    if (!body) return;
    const { laps, record } = this.store.get();
    await this.operations.attempt("Not learned", async () => {
      this.page.patch({
        macro: await this.port.learn({ ...body, laps, record, repeats: REPEATS, anew: false }),
      });
    });
  }

  /** The next run of the path with this key follows as planned. */
  async forget(key: string): Promise<void> {
    await this.operations.attempt("Not forgotten", async () => {
      await this.port.forget(key);
      const { result } = this.page.get();
      if (result?.learned?.key === key) this.page.patch({ result: { ...result, learned: null } });
    });
  }

  async steer(step: "pause" | "resume" | "stop"): Promise<void> {
    await this.operations.attempt(`Run not ${STEERED[step]}`, async () => {
      this.page.patch({ run: await this.port.steer(step) });
    });
  }

  /** The server's answer counts before its next status comes. */
  private async take(title: string, ask: () => Promise<RunState>, rmse: number | null): Promise<void> {
    await this.operations.attempt(title, async () => {
      const run = await ask();
      this.page.patch({ run });
      this.store.patch({ foreseen: rmse === null ? null : { run: run.id, rmse } });
    });
  }

  /** A prediction of something else is worth nothing. */
  private forgetOldPreview(): void {
    const [drawing, page] = [this.drawing.get(), this.page.get()];
    const subject = [drawing.source, page.chosen, page.settings, ...planInputs(drawing, page)];
    if (isSame(subject, this.subject)) return;
    this.subject = subject;
    this.store.patch({ preview: null });
    this.cancelPreview();
  }
}

function grown(ghost: Ghost | null, part: PreviewPart): Ghost {
  const whole = <T>(before: readonly T[] | undefined, more: readonly T[]) => [
    ...(before ?? []).slice(0, part.first),
    ...more,
  ];
  return {
    approach: [],
    points: whole(ghost?.points, part.points),
    saturated: whole(ghost?.saturated, part.saturated),
    start: part.start,
  };
}

const RECORD = "tendril-record-runs";

/** The switch "record each run" as it was on the last visit, and kept from now on. */
export function keepRecord(runs: Runs, storage: Pick<PageStorage, "getItem" | "setItem">): void {
  quietly(() => {
    if (storage.getItem(RECORD) === "off") runs.store.patch({ record: false });
  });
  runs.store.subscribe(() => {
    quietly(() => {
      storage.setItem(RECORD, runs.store.get().record ? "on" : "off");
    });
  });
}

const STEERED = { pause: "paused", resume: "resumed", stop: "stopped" } as const;

function subjectOf(
  drawing: DrawingState,
  page: Page,
): Pick<RunBody, "drawing" | "reference" | "K_FF"> | null {
  if (drawing.source === "library")
    return page.chosen === null ? null : { drawing: null, reference: page.chosen, K_FF: "published" };
  const body = bodyOf(drawing);
  return body && { drawing: body, reference: null, K_FF: "published" };
}

/** Follow what would be run. */
export function useRuns<S>(select: (choice: RunChoice) => S): S {
  return useStore(useService(Runs).store, select);
}

/** A run that has not ended. */
export function isUnderWay(run: RunState | null): run is RunState {
  return run !== null && (run.state === "approach" || run.state === "running" || run.state === "paused");
}

/** Why a path cannot be learned by this controller, as one sentence; null when it can. */
export function whyNotLearned(controller: ControllerInfo | undefined, endless: boolean): string | null {
  if (endless) return "What has no end is not repeated: give it a number of laps";
  if (controller?.plans === true) return null;
  return `Controller ${controller?.name ?? "unknown"} follows no plan: choose preview in Gains`;
}

/** Why what is chosen can be neither previewed nor run, as one sentence; null when it can. */
export function whyNotRun(drawing: DrawingState, chosen: ReferenceInfo | null): string | null {
  if (drawing.source === "drawing") return whyNotDrawing(drawing);
  if (!chosen) return "Choose a reference first";
  return chosen.reachable ? null : chosen.reason;
}

function whyNotDrawing(drawing: DrawingState): string | null {
  if (sketchOf(drawing).pieces.length === 0) return "Nothing is drawn";
  if (drawing.problem !== "") return drawing.problem;
  if (!drawing.plan || !isPlanned(drawing)) return "Being planned";
  return drawing.plan.reachable ? null : drawing.plan.reason;
}
