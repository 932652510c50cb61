import type { Point } from "../api/types";

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
