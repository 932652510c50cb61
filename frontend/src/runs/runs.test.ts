import { expect, test } from "vitest";
import type { Preview, RunBody, RunState } from "../api/types";
import { Drawing } from "../drawing/drawing";
import { drawingFacts } from "../drawing/facts";
import { pieceOf } from "../drawing/piece";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Store } from "../ui/store";
import { previewText, resultFacts } from "./facts";
import { keepRecord, Runs, whyNotRun } from "./runs";

const underWay = { state: "running", name: "vu" } as RunState;

const preview = { rmse: 1.234e-3, max_error: 4e-3, saturated_share: 0.05, broken_off: "" } as Preview;

function harness() {
  const [drawing, page] = [new Drawing(), new Store<Page>({ ...EMPTY_PAGE, chosen: "vu" })];
  const calls: string[] = [];
  const bodies: RunBody[] = [];
  const port = {
    preview: () => Promise.resolve(preview),
    run: (body: RunBody) => {
      bodies.push(body);
      return Promise.resolve(underWay);
    },
    steer: (step: string) => Promise.resolve({ ...underWay, state: step === "pause" ? "paused" : "stopped" } as RunState), // prettier-ignore
  };
  const attempt = async (title: string, action: () => Promise<unknown>) => {
    await action().catch(() => calls.push(title));
  };
  const runs = new Runs(drawing.store, page, { attempt }, port);
  return { drawing, page, runs, calls, bodies, port };
}

test("a run of the library is asked by name, of the drawing with the drawing, until stopped without a number", async () => {
  const { drawing, runs, bodies } = harness();
  runs.repeat(3);
  await runs.run();
  drawing.add([pieceOf([[0, 0.1], [0.1, 0.1]])]); // prettier-ignore
  drawing.chooseSource("drawing");
  runs.store.patch({ endless: true });
  await runs.run();
  expect(bodies[0]).toEqual({ drawing: null, reference: "vu", laps: 3, record: true });
  expect(bodies[1]).toMatchObject({ drawing: { name: "Drawing" }, reference: null, laps: null });
});

test("the switch for recording goes with the run, and is as it was on the last visit", async () => {
  const kept = new Map<string, string>();
  const shelf = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, text: string) => void kept.set(key, text) }; // prettier-ignore
  const { runs, bodies } = harness();
  keepRecord(runs, shelf);
  await runs.run();
  runs.store.patch({ record: false });
  const later = harness();
  keepRecord(later.runs, shelf);
  await later.runs.run();
  expect([bodies[0]?.record, later.bodies[0]?.record]).toEqual([true, false]);
});

test("a prediction is forgotten as soon as what would be run is another", async () => {
  const { page, runs } = harness();
  await runs.preview();
  expect(runs.store.get().preview).toBe(preview);
  page.patch({ hint: "unrelated" });
  expect(runs.store.get().preview).toBe(preview);
  page.patch({ chosen: "circle_1hz" });
  expect(runs.store.get().preview).toBeNull();
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
  expect(previewText({ ...preview, broken_off: "too fast" })[1]).toBe("too fast");
  const result = { id: 1, name: "vu", time: "", laps: 1, state: "done", reason: "", duration: 9, recording: null } as const; // prettier-ignore
  const numbers = { rmse: 1e-3, max_error: 2e-3, saturated_share: 0, on_time_share: 0.9999 };
  const names = (lag: number | null) =>
    resultFacts({ ...result, ...numbers, lag_deg_x: lag, lag_deg_y: lag }).map(([name]) => name);
  expect(names(null)).toEqual(["RMSE", "Max error", "Saturated", "On time"]);
  expect(names(-12)).toContain("Lag y");
  expect(drawingFacts(null).every(([, value]) => value === "–")).toBe(true);
});
