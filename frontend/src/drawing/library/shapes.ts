import type { ReferenceInfo } from "../../api/types";

/** A shape of the library, whatever its timing. */
export interface Shape {
  readonly name: string;
  readonly label: string;
  /** Laps a second of a periodic one [Hz]. */
  readonly frequency: number | null;
}

/** The library without what jumps, each shape once: "Circle, 1 Hz" is the circle again. */
export function shapesOf(references: readonly ReferenceInfo[]): Shape[] {
  const shapes = new Map<string, Shape>();
  for (const { name, title, frequency, peak_speed } of references) {
    const label = title.replace(/,.*$| \(.*\)$/, "");
    if (peak_speed !== null && !shapes.has(label)) shapes.set(label, { name, label, frequency });
  }
  return [...shapes.values()];
}
