import type { Point } from "../../api/types";

/** A measured marker, the observer's point at the same arc length, and whether the observer uses it. */
export interface Marker {
  /** 1 = nearest the base. */
  readonly rod: number;
  readonly measured: Point;
  readonly observed: Point | null;
  readonly sensed: boolean;
}

/** What `markersOf` reads; `Telemetry` offers it. */
export interface PointSource {
  points(name: "markers" | "backbone"): number;
  point(name: "markers" | "backbone", index: number): Point | null;
  at(name: "sensed"): number;
}

/** Every marker that is seen. Sensor i of n sits at i/n of the backbone, whose samples are evenly spread from the base. */
export function markersOf(source: PointSource): Marker[] {
  const count = source.points("markers");
  const samples = (source.points("backbone") - 1) / count;
  const mask = source.at("sensed");
  const markers: Marker[] = [];
  for (let rod = 1; rod <= count; rod++) {
    const measured = source.point("markers", rod - 1);
    if (!measured) continue;
    markers.push({
      rod,
      measured,
      observed: source.point("backbone", rod * samples),
      sensed: isSensed(mask, rod),
    });
  }
  return markers;
}

/** Bit rod-1 of the sensor mask. */
export function isSensed(mask: number, rod: number): boolean {
  return ((mask >> (rod - 1)) & 1) === 1;
}

/** Distance between measurement and observer [m], nan where one is missing. */
export function residualOf({ measured, observed }: Marker): number {
  return observed ? Math.hypot(measured[0] - observed[0], measured[1] - observed[1]) : NaN;
}

/** End of the arrow from the observer's point towards the measurement, drawn `gain` times as long. */
export function arrowEnd(observed: Point, measured: Point, gain: number): Point {
  return [observed[0] + (measured[0] - observed[0]) * gain, observed[1] + (measured[1] - observed[1]) * gain];
}

/** What `missOf` reads; `Telemetry` offers it. */
export interface TruthSource {
  points(name: "backbone" | "twin_backbone" | "markers"): number;
  point(name: "backbone" | "twin_backbone", index: number): Point | null;
}

/** Distance between the observer's estimate of rod `rod` and the twin's truth [m]; nan on hardware. */
export function missOf(source: TruthSource, rod: number): number {
  const index = (rod * (source.points("backbone") - 1)) / source.points("markers");
  const [estimate, truth] = [source.point("backbone", index), source.point("twin_backbone", index)];
  return estimate && truth ? Math.hypot(estimate[0] - truth[0], estimate[1] - truth[1]) : NaN;
}
