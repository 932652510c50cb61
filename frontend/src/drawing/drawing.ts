import type { DrawingBody, DrawingPlan, Point } from "../api/types";
import { useService } from "../ui/services";
import { Store, useStore } from "../ui/store";
import { begun, recorded, redone, undone, type History } from "./history";
import {
  distance,
  isSamePlace,
  pathOf,
  pieceOf,
  placed,
  POINTS_MAX,
  thinned,
  type Outline,
  type Piece,
} from "./piece";
import {
  apartFrom,
  bounded,
  changed,
  changedOutline,
  freeGroup,
  outlineOf,
  toggled,
  withGroups,
  type Change,
} from "./pieces/selection";
import { piecesOf, storedOf, strokeOf } from "./pieces/stored";

/** What the pointer does on the plan. */
export type Tool = "drag" | "select" | "freehand" | "polyline";
export type Timing = DrawingBody["timing"];

/** What undo brings back. */
export interface Sketch {
  readonly pieces: readonly Piece[];
  /** Indices of the pieces that handles move, rising; of a group all. */
  readonly selected: readonly number[];
  /** The path leads back to its first point. */
  readonly closed: boolean;
}

/** How the path is to be followed. */
export interface Manner {
  readonly timing: Timing;
  /** How far the followed path may be from the drawn one [m]. */
  readonly smoothing: number;
  readonly outside: DrawingBody["outside"];
}

/** What is to be followed: a reference of the library, or what is drawn. */
export type Source = "library" | "drawing";

export interface DrawingState {
  readonly source: Source;
  readonly tool: Tool;
  readonly history: History<Sketch>;
  /** The sketch in the middle of a gesture, before it counts. */
  readonly draft: Sketch | null;
  /** The box around what is selected in the middle of a gesture: it turns along. */
  readonly held: Outline | null;
  /** Corners of the box that is being drawn around pieces to select them [m]. */
  readonly marquee: readonly [Point, Point] | null;
  /** What is pressed comes to what is selected, as with Shift. */
  readonly several: boolean;
  /** The stroke being drawn [m]. */
  readonly stroke: readonly Point[];
  readonly manner: Manner;
  readonly name: string;
  /** What the server says about the drawing; the last one while it reads the next. */
  readonly plan: DrawingPlan | null;
  /** The pieces that `plan` is about. */
  readonly planOf: readonly Piece[] | null;
  /** Why the server has no plan for it. */
  readonly problem: string;
}

const SPEED = 0.02;
const STEADY: Timing = { kind: "speed", speed: SPEED };
const EMPTY: Sketch = { pieces: [], selected: [], closed: false };
/** Ends of a stroke this near to each other are meant to meet [m]. */
const CLOSING = 4e-3;
const COPY_OFFSET = 0.01;
/** Until a drawing has a name of its own. */
const UNNAMED = "Drawing";

export const EMPTY_DRAWING: DrawingState = {
  source: "library",
  tool: "drag",
  history: begun(EMPTY),
  draft: null,
  held: null,
  marquee: null,
  several: false,
  stroke: [],
  manner: { timing: STEADY, smoothing: 0, outside: "project" },
  name: "",
  plan: null,
  planOf: null,
  problem: "",
};

/** What is drawn now. */
export function sketchOf({ draft, history }: DrawingState): Sketch {
  return draft ?? history.present;
}

/** The server's plan is about what is drawn now. */
export function isPlanned(state: DrawingState): boolean {
  return state.plan !== null && state.planOf === sketchOf(state).pieces;
}

/** When each point is reached, as the file said; null for all but a file that is the only piece. */
export function timesOf(state: DrawingState): readonly number[] | null {
  const { pieces } = sketchOf(state);
  return pieces.length === 1 ? pieces[0].times : null;
}

/** The timing that counts: a file's own only as long as there are times of a file. */
export function timingNow(state: DrawingState): Timing {
  const { timing } = state.manner;
  return timing.kind === "given" && timesOf(state) === null ? STEADY : timing;
}

/** What handles move. */
export function selectionOf({ pieces, selected }: Sketch): Piece[] {
  return selected.map((i) => pieces[i]);
}

/** The drawing as the server takes it, null while there is no path. */
export function bodyOf(state: DrawingState): DrawingBody | null {
  const { pieces, closed } = sketchOf(state);
  const { smoothing, outside } = state.manner;
  const [times, timing] = [timesOf(state), timingNow(state)];
  if (pathOf(pieces).length < 2) return null;
  return {
    name: state.name.trim() || UNNAMED,
    ...(pieces.length === 1 ? aloneOf(pieces[0]) : storedOf(pieces)),
    times: times && thinned(times, POINTS_MAX),
    closed: closed && timing.kind !== "given",
    smoothing,
    timing,
    outside,
  };
}

/** A drawing of one piece is its stroke alone, unless it was turned or scaled; with times always. */
function aloneOf(piece: Piece): Pick<DrawingBody, "points" | "pieces"> {
  const { angle, scale } = piece.placement;
  if (piece.times) return strokeOf(placed(piece));
  return angle !== 0 || scale !== 1 ? storedOf([piece]) : strokeOf(pathOf([piece]));
}

/** What of a drawing outlives the page; undo and redo do not. */
export interface Kept {
  readonly sketch: Sketch;
  readonly manner: Manner;
  readonly name: string;
}

/** The editor: every change that counts can be undone. */
export class Drawing {
  readonly store = new Store<DrawingState>(EMPTY_DRAWING);

  /** Without the drawing there is nothing that a tool could act on. */
  chooseSource(source: Source): void {
    if (source === "library") this.choose("drag");
    this.store.patch({ source });
  }

  choose(tool: Tool): void {
    this.abandon();
    this.store.patch({ tool, several: false });
  }

  /** Draw the open stroke through these points; none abandons it. */
  trace(stroke: readonly Point[]): void {
    this.store.patch({ stroke });
  }

  /** The open stroke becomes a piece, closed where it comes back to its beginning. */
  finishStroke(): void {
    const { stroke } = this.store.get();
    this.store.patch({ stroke: [] });
    if (stroke.length < 2 || lengthOf(stroke) < CLOSING) return;
    this.add([pieceOf(stroke)], returns(stroke));
  }

  /** Add pieces, which are then selected. One that is `closed` leads back to its beginning, here or among others. */
  add(pieces: readonly Piece[], closed = false): void {
    const { sketch } = this;
    const before =
      sketch.closed && sketch.pieces.length === 1 ? sketch.pieces.map(closedPiece) : sketch.pieces;
    const alone = before.length === 0 && pieces.length === 1;
    const added = apartFrom(before, closed && !alone ? pieces.map(closedPiece) : pieces);
    const selected = added.map((_, i) => before.length + i);
    this.record({ pieces: [...before, ...added], selected, closed: closed && alone });
  }

  /** Move, turn and scale what is selected, from where it lay last; until `settle` it does not count. */
  change(wish: Change): void {
    const { present } = this.store.get().history;
    const selection = selectionOf(present);
    const outline = outlineOf(selection);
    if (!outline) return;
    const change = bounded(wish, selection);
    const pieces = changed(present.pieces, present.selected, change);
    this.store.patch({ draft: { ...present, pieces }, held: changedOutline(outline, change) });
  }

  /** Move what is selected by (dx, dy) [m] until `settle`. False if arrows are not the drawing's: with no other tool. */
  nudge(dx: number, dy: number): boolean {
    if (this.store.get().tool !== "select") return false;
    const { sketch } = this;
    const shift: Change = { about: [0, 0], shift: [dx, dy], angle: 0, scale: 1 };
    this.store.patch({ draft: { ...sketch, pieces: changed(sketch.pieces, sketch.selected, shift) } });
    return true;
  }

  /** Turn what is selected by `angle` [rad], as a step of its own. */
  turn(angle: number): void {
    const outline = outlineOf(this.selection);
    if (!outline) return;
    this.change({ about: outline.centre, shift: [0, 0], angle, scale: 1 });
    this.settle();
  }

  /** What was changed counts, as one step; the last stroke stays as it is. */
  settle(): void {
    const { draft, history } = this.store.get();
    if (draft && isMoved(draft, history.present)) this.record(draft);
    else this.store.patch({ draft: null, held: null });
  }

  /** A stroke, a box or a change is under way, which Esc abandons. */
  isOpen(): boolean {
    const { draft, marquee, stroke } = this.store.get();
    return draft !== null || marquee !== null || stroke.length > 0;
  }

  /** Forget a gesture that was broken off. */
  abandon(): void {
    this.store.patch({ draft: null, held: null, marquee: null, stroke: [] });
  }

  /** Select the pieces at these indices, and those grouped with them. */
  select(which: readonly number[]): void {
    const { history } = this.store.get();
    const { present } = history;
    const selected = withGroups(present.pieces, which);
    if (selected.join() !== present.selected.join())
      this.store.patch({ history: { ...history, present: { ...present, selected } } });
  }

  /** Select these pieces as well; where they all were, no longer. */
  toggle(which: readonly number[]): void {
    const { pieces, selected } = this.sketch;
    this.select(toggled(selected, withGroups(pieces, which)));
  }

  /** Select all, with a tool that has handles for it. */
  selectAll(): void {
    const { source, tool } = this.store.get();
    if (source !== "drawing") return;
    if (tool !== "drag") this.choose("select");
    this.select([...this.sketch.pieces.keys()]);
  }

  /** Draw the box that selects; null ends it. */
  frame(marquee: readonly [Point, Point] | null): void {
    this.store.patch({ marquee });
  }

  /** From now on, what is pressed comes to what is selected. */
  selectSeveral(several: boolean): void {
    this.store.patch({ several });
  }

  /** What is selected is one from now on: in one group, or each piece on its own. */
  group(isOne: boolean): void {
    const { pieces, selected } = this.sketch;
    if (isOne ? selected.length < 2 : this.selection.every(({ group }) => group === null)) return;
    const group = isOne ? freeGroup(pieces) : null;
    const picked = new Set(selected);
    const grouped = pieces.map((piece, i) => (picked.has(i) ? { ...piece, group } : piece));
    this.record({ ...this.sketch, pieces: grouped });
  }

  close(closed: boolean): void {
    this.record({ ...this.sketch, closed });
  }

  duplicate(): void {
    const { selection, sketch } = this;
    if (selection.length === 0) return;
    const copies = selection.map((piece): Piece => {
      const [x, y] = piece.placement.centre;
      const centre: Point = [x + COPY_OFFSET, y - COPY_OFFSET];
      return { ...piece, placement: { ...piece.placement, centre }, times: null };
    });
    this.add(copies, sketch.closed && sketch.pieces.length === 1);
  }

  /** Take what is selected away. */
  remove(): void {
    const { pieces, selected, closed } = this.sketch;
    if (selected.length === 0) return;
    const left = pieces.filter((_, i) => !selected.includes(i));
    this.record({
      pieces: left,
      selected: withGroups(left, left.length > 0 ? [left.length - 1] : []),
      closed,
    });
  }

  clear(): void {
    this.record(EMPTY);
    this.store.patch({ name: "" });
  }

  undo(): void {
    this.store.patch({ history: undone(this.store.get().history), draft: null, held: null });
  }

  redo(): void {
    this.store.patch({ history: redone(this.store.get().history), draft: null, held: null });
  }

  follow(manner: Partial<Manner>): void {
    this.store.patch({ manner: { ...this.store.get().manner, ...manner } });
  }

  rename(name: string): void {
    this.store.patch({ name });
  }

  /** Take a saved drawing as it was saved; undo brings the one before back. */
  load({ name, points, times, pieces, closed, smoothing, timing, outside }: DrawingBody): void {
    const loaded = pieces && !times ? piecesOf(points, pieces) : [pieceOf(points, times)];
    this.record({ pieces: loaded, selected: loaded.length === 1 ? [0] : [], closed });
    this.store.patch({ name, manner: { smoothing, timing, outside }, tool: "drag" });
  }

  /** Begin with what the last visit left. */
  restore({ sketch, manner, name }: Kept): void {
    this.store.patch({ history: begun(sketch), manner, name });
  }

  get selection(): Piece[] {
    return selectionOf(this.sketch);
  }

  private get sketch(): Sketch {
    return sketchOf(this.store.get());
  }

  private record(sketch: Sketch): void {
    this.store.patch({ history: recorded(this.store.get().history, sketch), draft: null, held: null });
  }
}

/** Follow a part of the drawing. */
export function useDrawing<S>(select: (drawing: DrawingState) => S): S {
  return useStore(useService(Drawing).store, select);
}

/** Ends that lie near each other against the way between them. */
export function returns(stroke: readonly Point[]): boolean {
  const [first, last] = [stroke.at(0), stroke.at(-1)];
  if (!first || !last) return false;
  return distance(first, last) < CLOSING && lengthOf(stroke) > 5 * CLOSING;
}

function isMoved(draft: Sketch, present: Sketch): boolean {
  return draft.pieces.some((piece, i) => !isSamePlace(piece.placement, present.pieces[i].placement));
}

function lengthOf(stroke: readonly Point[]): number {
  return stroke.reduce((sum, point, i) => sum + (i > 0 ? distance(stroke[i - 1], point) : 0), 0);
}

/** The piece led back to its first point. */
function closedPiece(piece: Piece): Piece {
  return { ...piece, shape: [...piece.shape, piece.shape[0]], times: null };
}
