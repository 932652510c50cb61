import type { Point, ReferenceInfo, ReferencePath } from "../../api/types";
import { hertz, millimetres, millimetresPerSecond, seconds, velocityGain } from "../../ui/format";
import { thinned } from "../piece";

interface Group {
  readonly group: string;
  readonly items: { readonly value: string; readonly label: string }[];
}

/** The menu: references grouped by task, in the server's order. */
export function menuOf(references: readonly ReferenceInfo[]): Group[] {
  const groups = new Map<string, Group>();
  for (const { task, name, title, reachable } of references) {
    const group = groups.get(task) ?? { group: task, items: [] };
    group.items.push({ value: name, label: reachable ? title : `${title} (out of reach)` });
    groups.set(task, group);
  }
  return [...groups.values()];
}

/** What is said about a reference: name and value of each fact. */
export function factsOf(info: ReferenceInfo): [string, string][] {
  const facts: [string, string][] = [
    ["Length", millimetres(info.length, 0)],
    ["Duration", seconds(info.duration)],
    ["Peak speed", info.peak_speed === null ? "jumps" : millimetresPerSecond(info.peak_speed)],
  ];
  if (info.frequency !== null) facts.push(["Frequency", hertz(info.frequency)]);
  if (info.K_FF > 0) facts.push(["K_FF", velocityGain([info.K_FF, info.K_FF])]);
  if (info.reachable && info.approach > 0) facts.push(["From rest", seconds(info.approach)]);
  return facts;
}

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

/**
 * A planned reference as it is drawn, without the way there, which depends on where the arm is: the preview has it. Of a
 * periodic shape only the first lap: dashes of several laps would fill each other's gaps.
 */
export function drawnShape({ t, points, start }: ReferencePath, frequency: number | null): readonly Point[] {
  const end = frequency === null ? Infinity : t[start] + 1 / frequency;
  const beyond = t.findIndex((time) => time > end);
  return points.slice(start, beyond < 0 ? t.length : beyond);
}

/** More points than this are not told apart in a small picture. */
const POINTS_MAX = 200;

/** An SVG path of the points as large as fits in the middle of a box [px], y up, equal scales; "" for no points. */
export function thumbnailPath(points: readonly Point[], width: number, height: number): string {
  const few = thinned(points, POINTS_MAX);
  const [left, right] = extremes(few.map(([x]) => x));
  const [bottom, top] = extremes(few.map(([, y]) => y));
  const scale = Math.min(width / Math.max(right - left, 1e-9), height / Math.max(top - bottom, 1e-9));
  const places = few.map(([x, y]) => [
    width / 2 + (x - (left + right) / 2) * scale,
    height / 2 - (y - (bottom + top) / 2) * scale,
  ]);
  return places
    .map((place, i) => `${i === 0 ? "M" : "L"}${place.map((px) => px.toFixed(1)).join(" ")}`)
    .join("");
}

function extremes(values: readonly number[]): [number, number] {
  return [Math.min(...values), Math.max(...values)];
}
