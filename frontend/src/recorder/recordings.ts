import { api, asCsv, dataOf } from "../api/rest";
import type { ImportedPath, Recording } from "../api/types";

/** What people may change of a recording. */
export type RecordingChanges = Partial<Pick<Recording, "name" | "tags" | "notes" | "starred">>;

/** Some of the recordings, how many fit what was searched, and how many there are. */
export interface Listed {
  readonly rows: readonly Recording[];
  readonly found: number;
  readonly inAll: number;
  /** How many are in the bin. */
  readonly deleted: number;
  /** The order in which they are. */
  readonly sort: string;
}

export const TIME_UNITS = ["s", "ms", "us", "ns"] as const;
export const LENGTH_UNITS = ["m", "cm", "mm"] as const;

export interface Units {
  readonly time: (typeof TIME_UNITS)[number];
  readonly length: (typeof LENGTH_UNITS)[number];
}

/** Units that a file leaves open. */
export interface UnitsMissing {
  readonly time: boolean;
  readonly length: boolean;
}

/** Which units a path's file leaves open; both where it could not be read, which sending it explains. */
export function unitsMissing(path: Pick<ImportedPath, "columns"> | null): UnitsMissing {
  const open = path?.columns.filter((column) => !column.stated).map((column) => column.name);
  return { time: open?.includes("t") ?? true, length: open?.some((name) => name !== "t") ?? true };
}

/** Formats, their short names, and who reads them. */
export const EXPORTS = [
  ["csv", "CSV", "One line a tick, units in the header: for anything."],
  ["parquet", "Parquet", "For pandas, polars, DuckDB and MATLAB."],
  ["mat", "MATLAB", "A struct “tendril” for MATLAB, Octave and scipy."],
  ["mcap", "MCAP", "Messages for Foxglove and PlotJuggler."],
  ["rrd", "rerun", "The recording as it is, whole, for rerun."],
] as const;
export type Format = (typeof EXPORTS)[number][0];

/** What is to be in an exported file; "" and none mean all. */
export interface ExportChoice {
  readonly signals: readonly string[];
  readonly from: number | string;
  readonly to: number | string;
  /** A CSV file begins with its origin, as lines with #. */
  readonly comments: boolean;
}

/** Address of the recording `id`, with `part` behind it. */
export function recordingUrl(id: string, part = ""): string {
  return `/api/recordings/${encodeURIComponent(id)}${part}`;
}

/** Address of rerun's own viewer, showing the recording at `url`; with null it shows nothing yet. */
export function viewerUrl(url: string | null, theme: "dark" | "light", renderer: string | null): string {
  const query = new URLSearchParams();
  if (url !== null) query.set("url", url);
  if (renderer !== null) query.set("renderer", renderer);
  return `/rerun/?${query.toString()}&hide_welcome_screen&persist=0&theme=${theme}`;
}

const at = (id: string) => ({ params: { path: { id } } });

export const recordings = {
  /** The first `limit` of those with every word of `search`, in the order `sort`: a column, "-" before it falls. */
  list: async (search: string, sort: string, limit: number, deleted: boolean): Promise<Listed> => {
    const query = { search, sort, limit, deleted };
    const { data: rows = [], response } = await api.GET("/api/recordings", { params: { query } });
    const count = (name: string) => Number(response.headers.get(name) ?? rows.length);
    return {
      rows,
      found: count("x-found"),
      inAll: count("x-in-all"),
      deleted: Number(response.headers.get("x-deleted") ?? 0),
      sort,
    };
  },
  /** Its figures, taken again. */
  metrics: (id: string) => dataOf(api.GET("/api/recordings/{id}/metrics", at(id))),
  /** What can be exported of it. */
  signals: (id: string) => dataOf(api.GET("/api/recordings/{id}/signals", at(id))),
  find: (id: string) => dataOf(api.GET("/api/recordings/{id}", at(id))),
  /** The quick look with at most `points` values of each of the signals `keys`. */
  quick: (id: string, points: number, keys: readonly string[]) => {
    const query = { points, signals: [...keys] };
    return dataOf(api.GET("/api/recordings/{id}/quick", { params: { path: { id }, query } }));
  },
  change: (id: string, body: RecordingChanges) =>
    dataOf(api.PATCH("/api/recordings/{id}", { ...at(id), body })),
  /** Into the bin. */
  remove: (id: string) => api.DELETE("/api/recordings/{id}", at(id)),
  /** Mark the newest row of the recording that runs. */
  mark: () => dataOf(api.POST("/api/recordings/current/bookmarks", { body: { label: "" } })),
  /** Give bookmark `n` a label, or with null remove it. */
  label: (id: string, n: number, label: string | null) => {
    const place = { params: { path: { id, n } } };
    const path = "/api/recordings/{id}/bookmarks/{n}";
    return dataOf(label === null ? api.DELETE(path, place) : api.PATCH(path, { ...place, body: { label } }));
  },
  restore: (id: string) => dataOf(api.POST("/api/recordings/{id}/restore", at(id))),
  emptyBin: () => api.DELETE("/api/recordings/deleted"),
  /** Have a file made: where it can be fetched, once. Who aborts cancels it. */
  makeExport: async (
    id: string,
    format: Format,
    choice: ExportChoice,
    signal: AbortSignal,
  ): Promise<string> => {
    const limit = (value: number | string) => (value === "" ? null : Number(value));
    const { signals, from, to, comments } = choice;
    const body = { format, signals: [...signals], start: limit(from), stop: limit(to), comments };
    const made = await dataOf(api.POST("/api/recordings/{id}/exports", { ...at(id), body, signal }));
    return `/api/exports/${encodeURIComponent(made.key)}`;
  },
  /** The recorded path of the tip or of its reference: the run, without what came before it and led into it. */
  path: (id: string, what: "p_meas" | "p_ref") =>
    dataOf(api.GET("/api/recordings/{id}/path", { params: { path: { id }, query: { what, run: true } } })),
  /** What a recording may keep of every tick, the default first. */
  profiles: () => dataOf(api.GET("/api/recordings/profiles")),
  /** A CSV file of another lab; `units` hold where its header names none. */
  take: (file: File, name: string, units: Units) => {
    const query = { name, time_unit: units.time, length_unit: units.length };
    return dataOf(api.POST("/api/recordings/import", { params: { query }, ...asCsv(file) }));
  },
};
