import type { DrawingPlan, Point } from "../../api/types";
import { isPlanned, sketchOf, type DrawingState } from "../../drawing/drawing";
import { placed, stretches } from "../../drawing/piece";
import type { Ghost } from "../../runs/runs";
import type { Trace } from "../../runs/trace";
import { ROLE } from "../../ui/colours";
import { polyline, type Sheet } from "./canvas";
import { paintHandles } from "./handles";

const OUTSIDE_DASH = [2, 5];
const TRAVEL_DASH = [1, 4];

/** The drawing: what is drawn (thin), what would be followed (dashed; dotted where it leads to another pose), what is out
 * of reach (red), and its handles. */
export function paintDrawing(sheet: Sheet, drawing: DrawingState, cursor: Point | null): void {
  const { g, ink } = sheet;
  const { pieces, selected } = sketchOf(drawing);
  g.save();
  g.lineJoin = "round";
  g.strokeStyle = isPlanned(drawing) ? ink.soft : ROLE.reference;
  for (const piece of pieces) line(sheet, placed(piece), isPlanned(drawing) ? 1 : 2);
  if (drawing.plan && isPlanned(drawing)) paintPlan(sheet, drawing.plan);
  g.strokeStyle = ROLE.reference;
  paintStroke(sheet, drawing, cursor);
  g.restore();
  const piece = selected === null ? undefined : pieces.at(selected);
  if (piece && drawing.tool === "drag") paintHandles(sheet, piece);
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

/** The predicted path: dotted, where the command saturates with a red band under it. */
export function paintGhost(sheet: Sheet, { points, start, saturated }: Ghost): void {
  const { g } = sheet;
  g.save();
  g.lineJoin = g.lineCap = "round";
  g.strokeStyle = ROLE.danger;
  g.globalAlpha = 0.5;
  for (const stretch of stretches(points, (i) => saturated[i])) line(sheet, stretch, 8);
  g.strokeStyle = ROLE.ghost;
  line(sheet, points.slice(0, start + 1), 1.5, [1, 5]);
  g.globalAlpha = 1;
  line(sheet, points.slice(start), 3, [0.5, 5]);
  g.restore();
}

/** Where the tip was measured in the last run. */
export function paintTrace(sheet: Sheet, legs: Trace["legs"]): void {
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
