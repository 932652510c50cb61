import { expect, test } from "vitest";
import type {
  ControllerInfo,
  LearnBody,
  MacroState,
  Preview,
  PreviewPart,
  RunBody,
  RunResult,
  RunState,
} from "../api/types";
import { Drawing } from "../drawing/drawing";
import { drawingFacts } from "../drawing/facts";
import { pieceOf } from "../drawing/piece";
import { MODE } from "../live/modes";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Store } from "../ui/store";
import { earlierOf, learnedText, previewText, resultFacts } from "./facts";
import { keepRecord, Runs, whyNotLearned, whyNotRun } from "./runs";

const KEY = "0123456789abcdef01234567";
const underWay = { id: 1, state: "running", name: "vu" } as RunState;

const preview = {
  rmse: 1.234e-3,
  max_error: 4e-3,
  saturated_share: 0.05,
  broken_off: "",
  K_FF: [0, 0],
} as unknown as Preview;

const ROWS: [number, number][] = [[0, 0.1], [0.01, 0.1], [0.02, 0.1]]; // prettier-ignore

/** What is foreseen of rows `first` to `end`; the last of it brings the whole. */
function part(first: number, end: number, more: Partial<PreviewPart> = {}): PreviewPart {
  const points = ROWS.slice(first, end);
  const t = points.map((_, i) => first + i);
  const whole = end === ROWS.length ? { ...preview, points: ROWS } : null;
  const saturated = points.map(() => false);
  return {
    first,
    t,
    points,
    saturated,
    start: 1,
    progress: end / ROWS.length,
    preview: whole,
    problem: "",
    ...more,
  };
}

function harness(parts: PreviewPart[] = [part(0, 3)]) {
  const [drawing, page] = [new Drawing(), new Store<Page>({ ...EMPTY_PAGE, chosen: "vu" })];
  const calls: string[] = [];
  const bodies: RunBody[] = [];
  const taught: LearnBody[] = [];
  const port = {
    preview: async function* () {
      for (const one of parts) yield await Promise.resolve(one);
    },
    run: (body: RunBody) => {
      bodies.push(body);
      return Promise.resolve(underWay);
    },
    again: () => Promise.resolve({ ...underWay, id: 2 }),
    learn: (body: LearnBody) => {
      taught.push(body);
      return Promise.resolve({ name: "vu", learning: true, state: "running" } as MacroState);
    },
    forget: (key: string) =>
      key === KEY ? Promise.resolve() : Promise.reject(new Error("nothing is known of it")),
    steer: (step: string) => Promise.resolve({ ...underWay, state: step === "pause" ? "paused" : "stopped" } as RunState), // prettier-ignore
  };
  const attempt = async (title: string, action: () => Promise<unknown>) => {
    await action().catch((error: unknown) => calls.push(`${title}: ${String(error)}`));
  };
  const runs = new Runs(drawing.store, page, { attempt }, port);
  return { drawing, page, runs, calls, bodies, taught, port };
}

test("a run of the library is asked by name, of the drawing with the drawing, until stopped without a number", async () => {
  const { drawing, runs, bodies } = harness();
  runs.repeat(3);
  await runs.run();
  drawing.add([pieceOf([[0, 0.1], [0.1, 0.1]])]); // prettier-ignore
  drawing.chooseSource("drawing");
  runs.store.patch({ endless: true });
  await runs.run();
  expect(bodies[0]).toEqual({
    drawing: null,
    reference: "vu",
    K_FF: "published",
    laps: 3,
    record: true,
    learning: "frozen",
  });
  expect(bodies[1]).toMatchObject({ drawing: { name: "Drawing" }, reference: null, laps: null });
});

test("a path is learned as often as it takes, and shown to be", async () => {
  const { page, runs, taught } = harness();
  runs.repeat(2);
  await runs.learn();
  expect(taught).toEqual([
    { drawing: null, reference: "vu", K_FF: "published", laps: 2, record: true, repeats: 8, anew: false },
  ]);
  expect(page.get().macro).toMatchObject({ learning: true, state: "running" });
});

test("what was learned is forgotten on the card once the server has", async () => {
  const { page, runs, calls } = harness();
  const learned = { key: KEY, learning: false, errors: [3e-3, null, 1e-3] };
  page.patch({ result: { id: 1, learned } as unknown as RunResult });
  await runs.forget("0");
  expect(page.get().result?.learned).toBe(learned);
  expect(calls).toHaveLength(1);
  await runs.forget(KEY);
  expect(page.get().result?.learned).toBeNull();
});

test("only a plan can be learned, of what has an end", () => {
  const [preview, paper] = [
    { name: "preview", plans: true },
    { name: "paper", plans: false },
  ] as ControllerInfo[];
  expect(whyNotLearned(preview, false)).toBeNull();
  expect(whyNotLearned(preview, true)).toContain("no end");
  expect(whyNotLearned(paper, false)).toContain("paper follows no plan: choose preview");
  expect(whyNotLearned(undefined, false)).toContain("unknown");
});

test("what was learned is told in a few words", () => {
  const errors = [3e-3, null, 1e-3];
  expect(learnedText({ key: KEY, learning: true, errors })).toBe("Repeat 3: best 1.00 mm");
  expect(learnedText({ key: KEY, learning: false, errors })).toBe("Learned in 3 repeats: best 1.00 mm");
  expect(learnedText({ key: KEY, learning: false, errors: [null] })).toBe("Learned in 1 repeat: best –");
});

test("the last run is followed again whatever is chosen now", async () => {
  const { page, runs } = harness();
  page.patch({ chosen: null });
  await runs.again();
  expect(page.get().run).toMatchObject({ id: 2, name: "vu" });
});

test("what was foreseen of a run stands beside its result, and beside the same followed again", async () => {
  const { page, runs } = harness();
  await runs.run();
  expect(runs.store.get().foreseen).toBeNull();
  await runs.preview();
  await runs.run();
  const run = page.get().run?.id ?? 0;
  expect(runs.store.get().foreseen).toEqual({ run, rmse: preview.rmse });
  page.patch({ result: ended(run, "vu") });
  await runs.again();
  expect(runs.store.get().foreseen).toEqual({ run: 2, rmse: preview.rmse });
  await runs.again();
  expect(runs.store.get().foreseen).toBeNull();
});

test("a result is compared with the last recorded run of the same before it", () => {
  const results = [
    ended(9, "vu"),
    ended(8, "vu", null),
    ended(7, "ring"),
    ended(6, "vu", "b"),
    ended(5, "vu"),
  ];
  expect(earlierOf(results[0], results)?.id).toBe(6);
  expect(earlierOf(results[2], results)).toBeNull();
  expect(earlierOf(results[4], results)).toBeNull();
});

function ended(id: number, name: string, recording: string | null = "a"): RunResult {
  const none = {
    max_error: null,
    lag_deg_x: null,
    lag_deg_y: null,
    saturated_share: null,
    on_time_share: null,
    K_FF: [0, 0] as [number, number],
    controller: "",
    learned: null,
  };
  const end = { time: "", laps: 1, state: "done" as const, reason: "", duration: 9, errors: [] };
  return { id, name, recording, rmse: null, ...none, ...end };
}

test("the switch for recording goes with the run, and is as it was on the last visit", async () => {
  const kept = new Map<string, string>();
  const storage = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, text: string) => void kept.set(key, text) }; // prettier-ignore
  const { runs, bodies } = harness();
  keepRecord(runs, storage);
  await runs.run();
  runs.store.patch({ record: false });
  const later = harness();
  keepRecord(later.runs, storage);
  await later.runs.run();
  expect([bodies[0]?.record, later.bodies[0]?.record]).toEqual([true, false]);
});

test("a prediction says in which mode it was made: its way to the path is another one elsewhere", async () => {
  const { page, runs } = harness();
  page.patch({ mode: MODE.HOLD });
  await runs.preview();
  page.patch({ mode: MODE.FOLLOW });
  expect(runs.store.get()).toMatchObject({ foreseenIn: MODE.HOLD, ghost: { points: ROWS } });
});

test("a prediction is forgotten as soon as what would be run is another", async () => {
  const { page, runs } = harness();
  await runs.preview();
  expect(runs.store.get().preview).toMatchObject(preview);
  page.patch({ hint: "unrelated" });
  expect(runs.store.get().preview).toMatchObject(preview);
  page.patch({ chosen: "circle_1hz" });
  expect(runs.store.get()).toMatchObject({ preview: null, ghost: null });
});

/** What the store says of the preview, at each change. */
function followed({ store }: Runs): string[] {
  const said: string[] = [];
  store.subscribe(() => {
    const { ghost, preview, previewing } = store.get();
    const share = previewing === null ? "-" : `${Math.round(100 * previewing)} %`;
    said.push(`${share}, ${ghost?.points.length ?? 0} rows${preview ? ", whole" : ""}`);
  });
  return said;
}

test("a preview is shown as it comes, and once more from where another process began it again", async () => {
  const { runs, calls } = harness([part(0, 1), part(1, 2), part(0, 2), part(2, 3)]);
  const said = followed(runs);
  await runs.preview();
  expect(said).toEqual(["0 %, 0 rows", "33 %, 1 rows", "67 %, 2 rows", "67 %, 2 rows", "100 %, 3 rows, whole", "-, 3 rows, whole"]); // prettier-ignore
  expect(runs.store.get().ghost?.points).toEqual(ROWS);
  expect(calls).toEqual([]);
});

test("a preview that is cancelled, or of something else by now, leaves nothing behind and no message", async () => {
  const cancels = [
    ({ runs }: ReturnType<typeof harness>) => {
      runs.cancelPreview();
    },
    ({ page }: ReturnType<typeof harness>) => {
      page.patch({ chosen: "circle_1hz" });
    },
  ];
  for (const cancel of cancels) {
    const made = harness([part(0, 1), part(1, 2), part(2, 3)]);
    made.runs.store.subscribe(() => {
      if (made.runs.store.get().ghost?.points.length === 2) cancel(made);
    });
    await made.runs.preview();
    expect(made.runs.store.get()).toMatchObject({ preview: null, ghost: null, previewing: null });
    expect(made.calls).toEqual([]);
  }
});

test("a preview that ends before its end says why", async () => {
  const { runs, calls } = harness([part(0, 1), part(1, 1, { problem: "the planner was killed twice" })]);
  await runs.preview();
  expect(calls).toEqual(["No preview: Error: the planner was killed twice"]);
  expect(runs.store.get()).toMatchObject({ preview: null, ghost: null, previewing: null });
});

test("what cannot be run says why", () => {
  const drawing = new Drawing();
  expect(whyNotRun(drawing.store.get(), null)).toBe("Choose a reference first");
  drawing.chooseSource("drawing");
  expect(whyNotRun(drawing.store.get(), null)).toBe("Nothing is drawn");
  drawing.add([pieceOf([[0, 0.1], [0.1, 0.1]])]); // prettier-ignore
  expect(whyNotRun(drawing.store.get(), null)).toBe("Being planned");
  drawing.store.patch({ problem: "no" });
  expect(whyNotRun(drawing.store.get(), null)).toBe("no");
});

test("a prediction and a result read in millimetres, without a lag where nothing is periodic", () => {
  expect(previewText(preview)).toEqual(["RMSE 1.23 mm, max 4.00 mm", "predicted; saturated 5.0 %"]);
  expect(previewText({ ...preview, K_FF: [0.0931, 0.0931] })[1]).toBe(
    "predicted; saturated 5.0 %, K_FF 0.093 s",
  );
  expect(previewText({ ...preview, broken_off: "too fast" })[1]).toBe("too fast");
  const result = ended(1, "vu", null);
  const numbers = { rmse: 1e-3, max_error: 2e-3, saturated_share: 0, on_time_share: 0.9999 };
  const names = (lag: number | null, foreseen: number | null = null) =>
    resultFacts({ ...result, ...numbers, lag_deg_x: lag, lag_deg_y: lag }, foreseen).map(([name]) => name);
  expect(names(null)).toEqual(["RMSE", "Max error", "Saturated", "On time"]);
  expect(names(-12)).toContain("Lag y");
  expect(resultFacts({ ...result, controller: "preview" }, null)).toContainEqual(["Controller", "preview"]);
  expect(resultFacts({ ...result, K_FF: [0.1, 0] }, null)).toContainEqual(["K_FF", "0.100, 0.000 s"]);
  expect(names(null, 1.1e-3).slice(0, 2)).toEqual(["RMSE", "Foreseen"]);
  expect(drawingFacts(null).every(([, value]) => value === "–")).toBe(true);
});
