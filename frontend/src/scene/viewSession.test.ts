import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { EMPTY_DRAWING } from "../drawing/drawing";
import { EMPTY_PAGE } from "../live/page";
import { FIRST_CHOICE } from "../runs/runs";
import { Replay } from "./Replay3D";
import type { Lines, Playback, SceneRole } from "./scene";
import { sceneLines, ViewSession } from "./viewSession";

beforeEach(() => vi.useFakeTimers());
afterEach(() => vi.useRealTimers());

const LINE: Lines = [
  [
    [0, 0],
    [0.1, 0],
  ],
];

test("a view session is told the newest of what is shown once its frame is there, and again when the server is back", async () => {
  const told: [SceneRole, number][] = [];
  const viewSession = new ViewSession({
    look: () => Promise.resolve(null),
    path: (_, role, lines) => {
      told.push([role, lines.length]);
      return Promise.resolve(null);
    },
  });
  const nothing = { reference: [], ghost: [], outside: [] };
  viewSession.show({ ...nothing, reference: LINE });
  await vi.runAllTimersAsync();
  expect(told).toEqual([]);
  viewSession.arrived("dark");
  await vi.runAllTimersAsync();
  viewSession.show({ ...nothing, reference: LINE, ghost: LINE });
  viewSession.show({ ...nothing, ghost: LINE });
  await vi.runAllTimersAsync();
  expect(told).toEqual([
    ["reference", 1],
    ["reference", 0],
    ["ghost", 1],
  ]);
  viewSession.arrived("dark");
  await vi.runAllTimersAsync();
  expect(told.at(-1)).toEqual(["ghost", 1]);
});

test("the 3D view shows what the plan shows: the chosen reference, its first lap only", () => {
  const points = Array.from({ length: 21 }, (_, i) => [i / 100, 1e-7] as [number, number]);
  const t = points.map((_, i) => i / 10);
  const reference = { name: "circle", t, points, start: 10 };
  const page = { ...EMPTY_PAGE, chosen: "circle", reference };
  const lines = sceneLines(page, EMPTY_DRAWING, FIRST_CHOICE).reference;
  expect(lines.map((line) => line.length)).toEqual([11]);
  expect(lines[0][3]).toEqual([0.13, 0]);
  expect(sceneLines(page, { ...EMPTY_DRAWING, source: "drawing" }, FIRST_CHOICE).reference).toEqual([]);
});

test("a replay follows the server's clock, stands at the end and begins again from there", async () => {
  let now = 0;
  const port = {
    play: (_: string, body: { recording: string; at?: number; playing?: boolean; rate?: number }) =>
      Promise.resolve<Playback>({ duration: 4, at: 0, playing: false, rate: 1, ...body }),
  };
  const replay = new Replay("one", "session", port, () => now);
  await replay.steer({ playing: true, rate: 2 });
  now = 1000;
  expect(replay.at()).toBe(2);
  await replay.toggle();
  now = 5000;
  expect([replay.at(), replay.isPlaying()]).toEqual([2, false]);
  await replay.toggle();
  now = 9000;
  expect([replay.at(), replay.isPlaying()]).toEqual([4, false]);
  await replay.toggle();
  expect([replay.at(), replay.isPlaying()]).toEqual([0, true]);
});
