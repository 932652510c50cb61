import { expect, test } from "vitest";
import type { DrawingBody, DrawingPlan, Point } from "../api/types";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Store } from "../ui/store";
import { bodyOf, Drawing, isPlanned, sketchOf, timingNow } from "./drawing";
import { begun, recorded, redone, undone } from "./history";
import { frameOf, gripAt, pathOf, pieceAt, pieceOf, placed, stretches, thinned } from "./piece";
import type { Change } from "./pieces/selection";
import { Planner } from "./planner";

const square: Point[] = [[0.1, 0.1], [0.12, 0.1], [0.12, 0.12], [0.1, 0.12]]; // prettier-ignore

function expectPoints(actual: readonly Point[], expected: readonly Point[]): void {
  expect(actual).toHaveLength(expected.length);
  actual.forEach((point, i) => {
    expect(point[0]).toBeCloseTo(expected[i][0], 9);
    expect(point[1]).toBeCloseTo(expected[i][1], 9);
  });
}

test("undo goes back step by step, redo forth, and a new step forgets what was undone", () => {
  const history = recorded(recorded(begun("a"), "b"), "c");
  expect(undone(undone(undone(history))).present).toBe("a");
  expect(redone(undone(history))).toEqual(history);
  expect(redone(recorded(undone(history), "d")).present).toBe("d");
});

test("a piece keeps its points, wherever its middle is", () => {
  expectPoints(placed(pieceOf(square)), square);
});

test("the frame stands around the outline and turns with it; its handles are hit within reach", () => {
  const frame = frameOf({ centre: [0.11, 0.11], half: [0.01, 0.01], angle: Math.PI / 2 }, 0.01, 0.02);
  expectPoints([frame.turn, frame.corners[0]], [[0.07, 0.11], [0.13, 0.09]]); // prettier-ignore
  expect(gripAt(frame, [0.072, 0.111], 0.004)).toBe("turn");
  expect(gripAt(frame, [0.131, 0.131], 0.004)).toBe("scale");
  expect(gripAt(frame, [0.11, 0.11], 0.004)).toBe("move");
  expect(gripAt(frame, [0.1, 0.1], 0.004)).toBeNull();
});

test("a piece is hit on its line, the newest of several, and not in its middle", () => {
  const pieces = [pieceOf(square), pieceOf([[0, 0], [0.2, 0]]), pieceOf([[0.05, -0.1], [0.05, 0.1]])]; // prettier-ignore
  expect(pieceAt(pieces, [0.11, 0.1005], 1e-3)).toBe(0);
  expect(pieceAt(pieces, [0.05, 0], 1e-3)).toBe(2);
  expect(pieceAt(pieces, [0.11, 0.11], 1e-3)).toBeNull();
});

test("a path repeats no point, and keeps first and last when thinned", () => {
  expectPoints(pathOf([pieceOf([[0, 0], [0.1, 0]]), pieceOf([[0.1, 0], [0.1, 0.1]])]), [[0, 0], [0.1, 0], [0.1, 0.1]]); // prettier-ignore
  const many = thinned(Array.from({ length: 12_345 }, (_, i) => i), 5000); // prettier-ignore
  expect([many.length, many.at(0), many.at(-1)]).toEqual([5000, 0, 12_344]);
});

test("a stroke that comes back to its beginning is closed; a dot is nothing", () => {
  const drawing = new Drawing();
  drawing.trace([[0.1, 0.1]]);
  drawing.finishStroke();
  expect(bodyOf(drawing.store.get())).toBeNull();
  drawing.trace([...square, [0.101, 0.101]]);
  drawing.finishStroke();
  expect(bodyOf(drawing.store.get())).toMatchObject({ closed: true, name: "Drawing" });
  expect(drawing.store.get().stroke).toEqual([]);
});

/** What is selected goes by so much [m]. */
function shift(dx: number, dy: number): Change {
  return { about: [0, 0], shift: [dx, dy], angle: 0, scale: 1 };
}

const centres = (drawing: Drawing) => drawing.selection.map(({ placement }) => placement.centre);

test("placing counts once, at its end; what is undone comes back; a copy lies beside", () => {
  const drawing = new Drawing();
  drawing.add([pieceOf(square)]);
  for (const dx of [0.09, 0.1, 0.11]) drawing.change(shift(dx, -0.11));
  drawing.abandon();
  expectPoints(centres(drawing), [[0.11, 0.11]]);
  for (const dx of [0.09, 0.1, 0.11]) drawing.change(shift(dx, -0.11));
  drawing.settle();
  drawing.duplicate();
  expect(sketchOf(drawing.store.get())).toMatchObject({ selected: [1] });
  expectPoints(centres(drawing), [[0.23, -0.01]]);
  drawing.undo();
  drawing.undo();
  expectPoints(centres(drawing), [[0.11, 0.11]]);
  drawing.redo();
  expectPoints(centres(drawing), [[0.22, 0]]);
});

const dot = (x: number, y: number) => pieceOf([[x, y], [x + 0.01, y]]); // prettier-ignore
const selected = (drawing: Drawing) => sketchOf(drawing.store.get()).selected;

test("a group is selected, moved, copied and taken away as one; each is one step", () => {
  const drawing = new Drawing();
  for (const x of [0, 0.1, 0.2]) drawing.add([dot(x, 0)]);
  drawing.select([0, 2]);
  drawing.group(true);
  drawing.select([1]);
  expect(selected(drawing)).toEqual([1]);
  drawing.select([2]);
  expect(selected(drawing)).toEqual([0, 2]);
  drawing.change(shift(0, 0.05));
  drawing.settle();
  expectPoints(centres(drawing), [[0.005, 0.05], [0.205, 0.05]]); // prettier-ignore
  drawing.duplicate();
  expect(selected(drawing)).toEqual([3, 4]);
  const groups = sketchOf(drawing.store.get()).pieces.map(({ group }) => group);
  expect(new Set([groups[0], groups[3]]).size).toBe(2);
  drawing.remove();
  expect(sketchOf(drawing.store.get()).pieces).toHaveLength(3);
  drawing.undo();
  drawing.undo();
  drawing.undo();
  drawing.select([0]);
  expectPoints(centres(drawing), [[0.005, 0], [0.205, 0]]); // prettier-ignore
  drawing.group(false);
  drawing.select([0]);
  expect(selected(drawing)).toEqual([0]);
  drawing.undo();
  drawing.undo();
  drawing.select([0]);
  expect(selected(drawing)).toEqual([0]);
});

test("with the select tool arrows move what is selected, held ones in one step; with others they are not the drawing's", () => {
  const drawing = new Drawing();
  drawing.add([dot(0, 0), dot(0.1, 0)]);
  expect(drawing.nudge(1e-3, 0)).toBe(false);
  drawing.choose("select");
  for (let i = 0; i < 5; i++) expect(drawing.nudge(1e-3, 0)).toBe(true);
  drawing.settle();
  expectPoints(centres(drawing), [[0.01, 0], [0.11, 0]]); // prettier-ignore
  drawing.undo();
  expectPoints(centres(drawing), [[0.005, 0], [0.105, 0]]); // prettier-ignore
  drawing.choose("polyline");
  drawing.trace([[0, 0], [0.1, 0]]); // prettier-ignore
  drawing.settle();
  expect(drawing.store.get().stroke).toHaveLength(2);
  drawing.selectAll();
  expect([drawing.store.get().tool, selected(drawing)]).toEqual(["polyline", [0, 1]]);
  drawing.chooseSource("drawing");
  drawing.select([]);
  drawing.selectAll();
  expect([drawing.store.get().tool, selected(drawing)]).toEqual(["select", [0, 1]]);
});

test("a closed stroke among others leads back to its own beginning", () => {
  const drawing = new Drawing();
  const loop: Point[] = [...square, [0.1, 0.101]];
  for (let i = 0; i < 2; i++) {
    drawing.trace(loop);
    drawing.finishStroke();
  }
  const { pieces, closed } = sketchOf(drawing.store.get());
  expect(closed).toBe(false);
  for (const piece of pieces) expectPoints([placed(piece).at(-1) ?? [0, 0]], [square[0]]);
});

test("several pieces are saved as such and come back where they were, turned and grouped; one alone as ever", () => {
  const drawing = new Drawing();
  drawing.add([pieceOf(square)]);
  expect(bodyOf(drawing.store.get())).toMatchObject({ pieces: null, closed: false });
  drawing.add([dot(0, 0), dot(0.1, 0.05)]);
  drawing.group(true);
  drawing.change({ about: [0, 0], shift: [0.01, 0], angle: 0.3, scale: 2 });
  drawing.settle();
  const body = bodyOf(drawing.store.get());
  if (!body) throw new Error("no body");
  expect(body.pieces?.map(({ points, group }) => [points, group])).toEqual([[4, null], [2, 1], [2, 1]]); // prettier-ignore
  expect(body.points).toHaveLength(8);
  const other = new Drawing();
  other.load(body);
  const [saved, loaded] = [drawing, other].map(({ store }) => sketchOf(store.get()).pieces);
  loaded.forEach((piece, i) => {
    expectPoints(placed(piece), placed(saved[i]));
    expectPoints(piece.shape, saved[i].shape);
    expect([piece.placement, piece.group]).toEqual([saved[i].placement, saved[i].group]);
  });
  expect(bodyOf(other.store.get())?.pieces).toEqual(body.pieces);
});

test("many strokes are thinned to what a drawing holds, none below its ends", () => {
  const drawing = new Drawing();
  const long = (n: number) => pieceOf(Array.from({ length: n }, (_, i): Point => [i * 1e-5, n]));
  drawing.add([long(20_000), ...Array.from({ length: 500 }, () => long(3))]);
  const body = bodyOf(drawing.store.get());
  const counts = body?.pieces?.map(({ points }) => points) ?? [];
  expect(counts).toHaveLength(501);
  expect(Math.min(...counts)).toBe(2);
  expect(counts.reduce((sum, count) => sum + count, 0)).toBe(body?.points.length);
  expect(body?.points.length).toBeLessThanOrEqual(5000);
  expect(body?.points.length).toBeGreaterThan(4000);
});

test("a file's own times go with the drawing as long as it is that file alone", () => {
  const drawing = new Drawing();
  drawing.add([pieceOf(square, [0, 1, 2, 3])]);
  drawing.follow({ timing: { kind: "given" } });
  expect(bodyOf(drawing.store.get())).toMatchObject({ times: [0, 1, 2, 3], timing: { kind: "given" } });
  drawing.add([pieceOf(square)]);
  expect(bodyOf(drawing.store.get())).toMatchObject({ times: null, timing: { kind: "speed" } });
});

/** A planner whose clock and server are in the test's hand. */
function planning() {
  const [drawing, page] = [new Drawing(), new Store<Page>(EMPTY_PAGE)];
  const due: (() => void)[] = [];
  const asked: { body: DrawingBody; give: (plan: DrawingPlan) => void; refuse: () => void }[] = [];
  const port = {
    plan: (body: DrawingBody) =>
      new Promise<DrawingPlan>((give, reject) => {
        asked.push({ body, give, refuse: () => { reject(new Error("speed is outside")); } }); // prettier-ignore
      }),
    later: (action: () => void) => due.push(action),
  };
  new Planner(drawing.store, page, port);
  page.patch({ rig: { boot: 1 } as Page["rig"] });
  const rest = async () => {
    for (const action of due.splice(0)) action();
    await Promise.resolve();
  };
  return { drawing, asked, rest };
}

const plan = { length: 0.1 } as DrawingPlan;

test("the server is asked once when the drawing rests, and a late answer is dropped", async () => {
  const { drawing, asked, rest } = planning();
  drawing.add([pieceOf(square)]);
  drawing.close(true);
  await rest();
  expect(asked.map(({ body }) => body.closed)).toEqual([true]);
  drawing.follow({ smoothing: 1e-3 });
  asked[0].give(plan);
  await rest();
  expect(isPlanned(drawing.store.get())).toBe(false);
  asked[1].give(plan);
  await new Promise((resolve) => setTimeout(resolve));
  expect(isPlanned(drawing.store.get())).toBe(true);
});

test("after a change of speed nothing is run by the plan of the old one", async () => {
  const { drawing, asked, rest } = planning();
  drawing.add([pieceOf(square)]);
  await rest();
  asked[0].give(plan);
  await new Promise((resolve) => setTimeout(resolve));
  expect(isPlanned(drawing.store.get())).toBe(true);
  drawing.follow({ timing: { kind: "speed", speed: 0.2 } });
  expect(isPlanned(drawing.store.get())).toBe(false);
});

test("a refusal is shown in the server's words until the drawing changes", async () => {
  const { drawing, asked, rest } = planning();
  drawing.add([pieceOf(square)]);
  await rest();
  asked[0].refuse();
  await new Promise((resolve) => setTimeout(resolve));
  expect(drawing.store.get()).toMatchObject({ plan: null, problem: "speed is outside" });
});

test("stretches begin one point earlier, so that a single point is seen", () => {
  const points: [number, number][] = [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0]]; // prettier-ignore
  expect(stretches(points, (i) => i === 0 || i === 3)).toEqual([[[0, 0]], [[2, 0], [3, 0]]]); // prettier-ignore
});

test("a file's own timing counts as long as the file is the only piece, and comes back with it", () => {
  const drawing = new Drawing();
  const timing = () => timingNow(drawing.store.get()).kind;
  drawing.add([pieceOf([[0, 0], [0.01, 0]], [0, 1])]); // prettier-ignore
  drawing.follow({ timing: { kind: "given" } });
  expect(timing()).toBe("given");
  drawing.clear();
  expect(timing()).toBe("speed");
  drawing.add([pieceOf(square)]);
  expect([timing(), bodyOf(drawing.store.get())?.timing.kind]).toEqual(["speed", "speed"]);
  drawing.undo();
  drawing.undo();
  expect(timing()).toBe("given");
});

test("a stroke, a box or a change that is under way is open until it counts or is abandoned", () => {
  const drawing = new Drawing();
  const gestures = [
    () => drawing.trace([[0, 0]]),
    () => drawing.frame([[0, 0], [1, 1]]), // prettier-ignore
    () => {
      drawing.select([0]);
      drawing.change({ about: [0, 0], shift: [0.01, 0], angle: 0, scale: 1 });
    },
  ];
  drawing.add([pieceOf(square)]);
  for (const begin of gestures) {
    expect(drawing.isOpen()).toBe(false);
    begin();
    expect(drawing.isOpen()).toBe(true);
    drawing.abandon();
  }
  expect(drawing.isOpen()).toBe(false);
});
