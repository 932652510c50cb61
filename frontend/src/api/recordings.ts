import { call } from "./rest";
import type { Point, Quick, Recording } from "./types";

/** What people may change of a recording. */
export type RecordingChanges = Partial<Pick<Recording, "name" | "tags" | "notes" | "starred">>;

/** A recorded path [m] over time [s], ready to be followed. */
export interface RecordedPath {
  readonly points: Point[];
  readonly times: number[];
}

export const EXPORTS = [
  ["csv", "CSV"],
  ["parquet", "Parquet"],
  ["mat", "MATLAB .mat"],
  ["mcap", "MCAP (Foxglove, PlotJuggler)"],
] as const;

/** Address of the recording `id`, with `part` behind it. */
export function recordingUrl(id: string, part = ""): string {
  return `/api/recordings/${encodeURIComponent(id)}${part}`;
}

export const recordings = {
  list: () => call<Recording[]>("GET", "/api/recordings"),
  quick: (id: string, points: number) => call<Quick>("GET", recordingUrl(id, `/quick?points=${points}`)),
  change: (id: string, changes: RecordingChanges) => call<Recording>("PATCH", recordingUrl(id), changes),
  remove: (id: string) => call<unknown>("DELETE", recordingUrl(id)),
  path: (id: string) => call<RecordedPath>("GET", recordingUrl(id, "/path")),
};
