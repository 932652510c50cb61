import { expect, test } from "vitest";
import type { DrawingBody, DrawingPlan, Point } from "../api/types";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Store } from "../ui/store";
import { bodyOf, Drawing, isPlanned, sketchOf, timingNow } from "./drawing";
import { begun, recorded, redone, undone } from "./history";
import { dragged, frameOf, gripAt, pathOf, pieceAt, pieceOf, placed, stretches, thinned } from "./piece";
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

test("a handle moves, scales about the middle, or turns about it", () => {
  const piece = pieceOf(square);
  const moved = dragged(piece.placement, "move", [0.1, 0.1], [0.15, 0.08]);
  expectPoints(placed({ ...piece, placement: moved }).slice(0, 1), [[0.15, 0.08]]);
  const scaled = dragged(piece.placement, "scale", [0.12, 0.12], [0.13, 0.13]);
  expectPoints(placed({ ...piece, placement: scaled }).slice(2, 3), [[0.13, 0.13]]);
  const turned = dragged(piece.placement, "turn", [0.11, 0.15], [0.05, 0.11]);
  expectPoints(placed({ ...piece, placement: turned }), [[0.12, 0.1], [0.12, 0.12], [0.1, 0.12], [0.1, 0.1]]); // prettier-ignore
});

test("the frame stands around the piece and turns with it; its handles are hit within reach", () => {
  const piece = pieceOf(square);
  const quarter = { ...piece, placement: { ...piece.placement, angle: Math.PI / 2 } };
  const frame = frameOf(quarter, 0.01, 0.02);
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

test("the pen never lifts, repeats no point, and keeps first and last when thinned", () => {
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

test("placing counts once, at its end; what is undone comes back; a copy lies beside", () => {
  const drawing = new Drawing();
  drawing.add([pieceOf(square)]);
  const { placement } = pieceOf(square);
  for (const x of [0.2, 0.21, 0.22]) drawing.place(0, { ...placement, centre: [x, 0] });
  drawing.abandon();
  expect(drawing.selectedPiece?.placement).toEqual(placement);
  for (const x of [0.2, 0.21, 0.22]) drawing.place(0, { ...placement, centre: [x, 0] });
  drawing.settle();
  drawing.duplicate();
  expect(sketchOf(drawing.store.get())).toMatchObject({ selected: 1 });
  expectPoints([drawing.selectedPiece?.placement.centre ?? [0, 0]], [[0.23, -0.01]]);
  drawing.undo();
  drawing.undo();
  expect(drawing.selectedPiece?.placement).toEqual(placement);
  drawing.redo();
  expect(drawing.selectedPiece?.placement.centre).toEqual([0.22, 0]);
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
