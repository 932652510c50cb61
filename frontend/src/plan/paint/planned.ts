import type { Point } from "../../api/types";
import type { PlannedLines } from "../../drawing/library/shown";
import { ROLE } from "../../ui/colours";
import { polyline, type Sheet } from "./canvas";

export function paintPlanned(sheet: Sheet, { approach, shape }: PlannedLines): void {
  const { g } = sheet;
  g.save();
  g.strokeStyle = ROLE.reference;
  g.lineJoin = "round";
  stroke(sheet, approach, 1, [2, 4]);
  stroke(sheet, shape, 2, [7, 4]);
  g.restore();
}

function stroke(sheet: Sheet, points: readonly Point[], width: number, dash: number[]): void {
  sheet.g.lineWidth = width;
  sheet.g.setLineDash(dash);
  polyline(sheet, points);
  sheet.g.stroke();
}
