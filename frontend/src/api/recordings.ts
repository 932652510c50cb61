import { call } from "./rest";
import type { Point, ProfileInfo, Quick, Recording } from "./types";

/** What people may change of a recording. */
export type RecordingChanges = Partial<Pick<Recording, "name" | "tags" | "notes" | "starred">>;

/** A recorded path [m] over time [s], ready to be followed. */
export interface RecordedPath {
  readonly name: string;
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
  /** The quick look with at most `points` values of each of the signals `keys`. */
  quick: (id: string, points: number, keys: readonly string[]) => {
    const query = new URLSearchParams([["points", String(points)], ...keys.map((key) => ["signals", key])]);
    return call<Quick>("GET", recordingUrl(id, `/quick?${query.toString()}`));
  },
  change: (id: string, changes: RecordingChanges) => call<Recording>("PATCH", recordingUrl(id), changes),
  remove: (id: string) => call<unknown>("DELETE", recordingUrl(id)),
  /** What a recording may keep of every tick, the default first. */
  profiles: () => call<ProfileInfo[]>("GET", "/api/recordings/profiles"),
  /** The recorded path of the tip or of its reference. */
  path: (id: string, what: "p_meas" | "p_ref") =>
    call<RecordedPath>("GET", recordingUrl(id, `/path?what=${what}`)),
};
