import { expect, test } from "vitest";
import type { Point, RunState } from "../api/types";
import type { Live } from "../live/live";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Store } from "../ui/store";
import { RunTrace } from "./trace";

/** A trace, and what a run's next frame does to it. */
function traced() {
  const page = new Store<Page>(EMPTY_PAGE);
  let [tick, tip] = [0, [0, 0] as Point];
  const telemetry = { at: () => tick, point: () => tip } as unknown as Live["telemetry"];
  const trace = new RunTrace({ telemetry }, page);
  let now = 0;
  const frame = (id: number, state: RunState["state"], point: Point, after = 250) => {
    tick += 1;
    now += after;
    tip = point;
    page.patch({ run: { id, state } as RunState });
    trace.look(now);
  };
  return { trace, frame, legs: () => trace.store.get().legs };
}

test("a run leaves where it was measured, without approach and pause, until it is cleared", () => {
  const { trace, frame, legs } = traced();
  frame(1, "approach", [0.2, 0]);
  frame(1, "running", [0.1, 0]);
  frame(1, "running", [0.11, 0]);
  frame(1, "running", [0.1101, 0]); // noise is no step
  frame(1, "paused", [0.15, 0]);
  frame(1, "approach", [0.16, 0]);
  frame(1, "running", [0.12, 0]);
  frame(1, "done", [0.3, 0]);
  const path = [
    [
      [0.1, 0],
      [0.11, 0],
    ],
    [[0.12, 0]],
  ];
  expect(legs()).toEqual(path);
  frame(1, "done", [0.4, 0]);
  expect(legs()).toEqual(path);
  trace.clear();
  frame(1, "done", [0.4, 0]);
  expect(legs()).toEqual([]);
});

test("the next run takes the place of the last one, and what is cleared while it runs goes on from there", () => {
  const { trace, frame, legs } = traced();
  frame(1, "running", [0.1, 0]);
  frame(2, "approach", [0.2, 0]);
  expect(legs()).toEqual([]);
  frame(2, "running", [0.3, 0]);
  trace.clear();
  frame(2, "running", [0.31, 0]);
  expect(legs()).toEqual([[[0.31, 0]]]);
});

test("where the page saw nothing for a while, no line is drawn through", () => {
  const { frame, legs } = traced();
  frame(1, "running", [0.1, 0]);
  frame(1, "running", [0.1, 0.01]);
  frame(1, "running", [0.1, 0.2], 3000);
  frame(1, "running", [0.1, 0.21]);
  expect(legs().map((leg) => leg.length)).toEqual([2, 2]);
});

test("hours of laps take no more than so many points", () => {
  const { frame, legs } = traced();
  for (let i = 0; i < 20_000; i++) frame(1, "running", [0.01 * Math.cos(i), 0.01 * Math.sin(i)]);
  expect(legs()[0].length).toBeLessThanOrEqual(8000);
  expect(legs()[0].length).toBeGreaterThan(3000);
});
