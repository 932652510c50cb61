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
  type Piece,
  type Placement,
} from "./piece";

/** What the pointer does on the plan. */
export type Tool = "drag" | "freehand" | "polyline";
export type Timing = DrawingBody["timing"];

/** What undo brings back. */
export interface Sketch {
  readonly pieces: readonly Piece[];
  /** Index of the piece with handles, null for none. */
  readonly selected: number | null;
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
const EMPTY: Sketch = { pieces: [], selected: null, closed: false };
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

/** The drawing as the server takes it, null while there is no path. */
export function bodyOf(state: DrawingState): DrawingBody | null {
  const { pieces, closed } = sketchOf(state);
  const { smoothing, outside } = state.manner;
  const [times, timing] = [timesOf(state), timingNow(state)];
  const path = times ? placedAll(pieces) : pathOf(pieces);
  if (path.length < 2) return null;
  return {
    name: state.name.trim() || UNNAMED,
    points: thinned(path, POINTS_MAX).map(([x, y]) => [x, y]),
    times: times && thinned(times, POINTS_MAX),
    closed: closed && timing.kind !== "given",
    smoothing,
    timing,
    outside,
  };
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

  chooseSource(source: Source): void {
    this.store.patch({ source });
  }

  choose(tool: Tool): void {
    this.store.patch({ tool, stroke: [] });
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
    const closed = this.sketch.pieces.length === 0 && returns(stroke);
    this.add([pieceOf(stroke)], closed);
  }

  /** Add pieces, the last of them selected. */
  add(pieces: readonly Piece[], closed = false): void {
    const all = [...this.sketch.pieces, ...pieces];
    this.record({ pieces: all, selected: all.length - 1, closed });
  }

  /** Put piece `index` elsewhere; until `settle` it does not count. */
  place(index: number, placement: Placement): void {
    const pieces = this.sketch.pieces.map((piece, i) => (i === index ? { ...piece, placement } : piece));
    this.store.patch({ draft: { ...this.sketch, pieces } });
  }

  settle(): void {
    const { draft, history } = this.store.get();
    if (draft && isMoved(draft, history.present)) this.record(draft);
    else this.abandon();
  }

  /** Forget a gesture that was broken off. */
  abandon(): void {
    this.store.patch({ draft: null, stroke: [] });
  }

  select(selected: number | null): void {
    const { history } = this.store.get();
    if (history.present.selected !== selected)
      this.store.patch({ history: { ...history, present: { ...history.present, selected } } });
  }

  close(closed: boolean): void {
    this.record({ ...this.sketch, closed });
  }

  duplicate(): void {
    const piece = this.selectedPiece;
    if (!piece) return;
    const [x, y] = piece.placement.centre;
    const centre: Point = [x + COPY_OFFSET, y - COPY_OFFSET];
    this.add([{ ...piece, placement: { ...piece.placement, centre }, times: null }], this.sketch.closed);
  }

  /** Take the selected piece away. */
  remove(): void {
    const { pieces, selected, closed } = this.sketch;
    if (selected === null) return;
    const left = pieces.filter((_, i) => i !== selected);
    this.record({ pieces: left, selected: left.length > 0 ? left.length - 1 : null, closed });
  }

  clear(): void {
    this.record(EMPTY);
    this.store.patch({ name: "" });
  }

  undo(): void {
    this.store.patch({ history: undone(this.store.get().history), draft: null });
  }

  redo(): void {
    this.store.patch({ history: redone(this.store.get().history), draft: null });
  }

  follow(manner: Partial<Manner>): void {
    this.store.patch({ manner: { ...this.store.get().manner, ...manner } });
  }

  rename(name: string): void {
    this.store.patch({ name });
  }

  /** Take a saved drawing as it was saved; undo brings the one before back. */
  load({ name, points, times, closed, smoothing, timing, outside }: DrawingBody): void {
    this.record({ pieces: [pieceOf(points, times)], selected: 0, closed });
    this.store.patch({ name, manner: { smoothing, timing, outside }, tool: "drag" });
  }

  /** Begin with what the last visit left. */
  restore({ sketch, manner, name }: Kept): void {
    this.store.patch({ history: begun(sketch), manner, name });
  }

  get selectedPiece(): Piece | null {
    const { pieces, selected } = this.sketch;
    return selected === null ? null : (pieces.at(selected) ?? null);
  }

  private get sketch(): Sketch {
    return sketchOf(this.store.get());
  }

  private record(sketch: Sketch): void {
    this.store.patch({ history: recorded(this.store.get().history, sketch), draft: null });
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

function placedAll(pieces: readonly Piece[]): Point[] {
  return pieces.flatMap(placed);
}
