import type { DrawingPlan, Point, ReferencePath } from "../../api/types";
import { isPlanned, selectionOf, sketchOf, type Drawing, type DrawingState } from "../../drawing/drawing";
import { chosenInfo } from "../../drawing/library/references";
import { drawnShape } from "../../drawing/library/shown";
import { isSame } from "../../drawing/planner";
import type { Page } from "../../live/page";
import type { Ghost, Runs } from "../../runs/runs";
import type { RunTrace, Trace } from "../../runs/trace";
import type { Store } from "../../ui/store";
import { polyline, type Look, type Sheet } from "./canvas";
import { ROLE } from "../../ui/colours";
import { placed, stretches, type Piece } from "../../drawing/piece";
import { outlineOf } from "../../drawing/pieces/selection";
import { paintHandles } from "./handles";

/** What is wanted and predicted, between paper and figure: painted when it or the view changes. */
export class SketchLayer {
  /** Where the pointer is [m]. */
  cursor: Point | null = null;
  private painted: readonly unknown[] = [];
  private reference: ReferencePath | null = null;
  private shape: readonly Point[] = [];

  constructor(
    private readonly drawing: Drawing,
    private readonly runs: Runs,
    private readonly trace: RunTrace,
    private readonly page: Store<Page>,
  ) {}

  /** Paint on the sheet that `open` gives, if there is something new. */
  paint(look: Look, open: () => Sheet | null): void {
    const { ghost, foreseenIn } = this.runs.store.get();
    const state = this.drawing.store.get();
    const cursor = state.stroke.length > 0 ? this.cursor : null;
    const { legs } = this.trace.store.get();
    const departs = this.page.get().mode === foreseenIn;
    const shown = [look, ghost, departs, state, this.page.get().reference, cursor, legs];
    if (isSame(shown, this.painted)) return;
    const sheet = open();
    if (!sheet) return;
    sheet.g.clearRect(0, 0, sheet.size.width, sheet.size.height);
    if (state.source === "drawing" && (!look.hidden.has("path") || state.tool !== "drag"))
      paintDrawing(sheet, state, cursor);
    if (state.source === "library" && !look.hidden.has("path")) this.paintReference(sheet);
    if (ghost && !look.hidden.has("predicted")) paintGhost(sheet, ghost, departs);
    if (!look.hidden.has("measured")) paintTrace(sheet, legs);
    this.painted = shown;
  }

  private paintReference(sheet: Sheet): void {
    const page = this.page.get();
    const { reference } = page;
    if (reference !== this.reference) {
      const frequency = chosenInfo(page)?.frequency ?? null;
      this.reference = reference;
      this.shape = reference ? drawnShape(reference, frequency) : [];
    }
    paintShape(sheet, this.shape);
  }
}

function paintShape(sheet: Sheet, shape: readonly Point[]): void {
  const { g } = sheet;
  g.save();
  g.strokeStyle = ROLE.reference;
  g.lineJoin = "round";
  line(sheet, shape, 2, [7, 4]);
  g.restore();
}

const OUTSIDE_DASH = [2, 5];
const TRAVEL_DASH = [3, 4];
const MARQUEE_DASH = [4, 3];

/** The drawing: what is drawn (thin), what would be followed (dashed; thin where it only leads to the next stroke, or to
 * another pose), what is out of reach (red), and the handles of what is selected. */
function paintDrawing(sheet: Sheet, drawing: DrawingState, cursor: Point | null): void {
  const { g, ink } = sheet;
  const sketch = sketchOf(drawing);
  const { pieces } = sketch;
  const isHandled = drawing.tool === "drag" || drawing.tool === "select";
  const selection = isHandled ? selectionOf(sketch) : [];
  g.save();
  g.lineJoin = g.lineCap = "round";
  if (pieces.length > 1) paintSelected(sheet, selection);
  g.lineCap = "butt";
  g.strokeStyle = isPlanned(drawing) ? ink.soft : ROLE.reference;
  for (const piece of pieces) line(sheet, placed(piece), isPlanned(drawing) ? 1 : 2);
  if (drawing.plan && isPlanned(drawing)) paintPlan(sheet, drawing.plan);
  g.strokeStyle = ROLE.reference;
  paintStroke(sheet, drawing, cursor);
  if (drawing.marquee) paintMarquee(sheet, drawing.marquee);
  g.restore();
  const outline = drawing.held ?? outlineOf(selection);
  if (outline) paintHandles(sheet, outline);
}

/** Which of several pieces the handles move: a broad band under each. */
function paintSelected(sheet: Sheet, selection: readonly Piece[]): void {
  const { g } = sheet;
  g.strokeStyle = ROLE.reference;
  g.globalAlpha = 0.3;
  for (const piece of selection) line(sheet, placed(piece), 8);
  g.globalAlpha = 1;
}

function paintMarquee(sheet: Sheet, corners: readonly [Point, Point]): void {
  const { g, ink } = sheet;
  const [[x0, y0], [x1, y1]] = corners.map(sheet.pixel);
  g.setLineDash(MARQUEE_DASH);
  g.lineWidth = 1;
  g.strokeStyle = g.fillStyle = ink.soft;
  g.strokeRect(x0, y0, x1 - x0, y1 - y0);
  g.globalAlpha = 0.12;
  g.fillRect(x0, y0, x1 - x0, y1 - y0);
  g.globalAlpha = 1;
}

/** The stroke being drawn; with the polyline, on to the cursor. */
function paintStroke(sheet: Sheet, { stroke, tool }: DrawingState, cursor: Point | null): void {
  if (stroke.length === 0) return;
  line(sheet, tool === "polyline" && cursor ? [...stroke, cursor] : stroke, 2);
}

function paintPlan(sheet: Sheet, { points, wished, inside, travel }: DrawingPlan): void {
  const { g } = sheet;
  g.strokeStyle = ROLE.reference;
  for (const stretch of stretches(points, (i) => !travel[i])) line(sheet, stretch, 2, [7, 4]);
  for (const stretch of stretches(points, (i) => travel[i])) line(sheet, stretch, 1, TRAVEL_DASH);
  g.strokeStyle = ROLE.danger;
  for (const stretch of stretches(wished, (i) => !inside[i])) line(sheet, stretch, 3.5, OUTSIDE_DASH);
}

/**
 * The predicted path: dotted, where the command saturates with a red band under it. The way there, and how the reference
 * is led along it, only while the arm stands where it was foreseen from.
 */
function paintGhost(sheet: Sheet, { approach, points, start, saturated }: Ghost, departs: boolean): void {
  const { g } = sheet;
  g.save();
  g.lineJoin = g.lineCap = "round";
  g.strokeStyle = ROLE.danger;
  g.globalAlpha = 0.5;
  for (const stretch of stretches(points, (i) => saturated[i])) line(sheet, stretch, 8);
  g.strokeStyle = ROLE.reference;
  if (departs) line(sheet, approach, 1, [2, 4]);
  g.strokeStyle = ROLE.ghost;
  if (departs) line(sheet, points.slice(0, start + 1), 1.5, [1, 5]);
  g.globalAlpha = 1;
  line(sheet, points.slice(start), 3, [0.5, 5]);
  g.restore();
}

/** Where the tip was measured in the last run. */
function paintTrace(sheet: Sheet, legs: Trace["legs"]): void {
  const { g } = sheet;
  g.save();
  g.lineJoin = g.lineCap = "round";
  g.strokeStyle = ROLE.measured;
  for (const leg of legs) line(sheet, leg, 1.5);
  g.restore();
}

function line(sheet: Sheet, points: readonly Point[], width: number, dash: number[] = []): void {
  sheet.g.lineWidth = width;
  sheet.g.setLineDash(dash);
  polyline(sheet, points);
  sheet.g.stroke();
}
