import type { Point, ReferencePath } from "../../api/types";
import { ROLE } from "../../ui/colours";
import { polyline, type Sheet } from "./canvas";

/** A planned reference as it is drawn: the way from rest, and the shape once. */
export interface PlannedLines {
  readonly approach: readonly Point[];
  readonly shape: readonly Point[];
}

/** Of a periodic shape only the first lap: dashes of several laps would fill each other's gaps. */
export function plannedLines({ t, points, start }: ReferencePath, frequency: number | null): PlannedLines {
  const end = frequency === null ? Infinity : t[start] + 1 / frequency;
  const beyond = t.findIndex((time) => time > end);
  return { approach: points.slice(0, start + 1), shape: points.slice(start, beyond < 0 ? t.length : beyond) };
}

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
