import type { Recording } from "../../api/types";

export type Column =
  | "starred"
  | "name"
  | "started"
  | "actuator"
  | "reference"
  | "seconds"
  | "rmse"
  | "on_time_share"
  | "gaps"
  | "bytes";

export interface Order {
  readonly column: Column;
  readonly falling: boolean;
}

export const NEWEST: Order = { column: "started", falling: true };

const WORDS = new Set<Column>(["name", "actuator", "reference"]);

/** As the server takes it. */
export function sortOf({ column, falling }: Order): string {
  return `${falling ? "-" : ""}${column}`;
}

/** A click on a title: fall first where large is interesting, turn round at the second. */
export function nextOrder(order: Order, column: Column): Order {
  if (order.column === column) return { column, falling: !order.falling };
  return { column, falling: !WORDS.has(column) };
}

/** How long after its end a recording may wait for its figures [ms]. */
const MEASURING_MS = 120_000;

/** Nothing of it changes by itself any more: its figures were taken, or no one will take them. */
export function isSettled({ metrics, imported, problem, started, seconds }: Recording, now: number): boolean {
  const end = Date.parse(started) + 1e3 * seconds;
  return metrics !== null || imported || problem !== "" || now - end > MEASURING_MS;
}

/** Its picture is being made: it is an older one, and someone looks at it for the first time. */
export function wantsPicture({ thumbnail, complete, problem }: Recording): boolean {
  return thumbnail === null && complete && problem === "";
}

const DAY_MS = 86_400_000;

/** When it began as people say it: "Today 20:44", "Yesterday 08:10", "12 Mar 20:44", with the year where that is another one. */
export function whenText(iso: string, now: Date): string {
  const at = new Date(iso);
  const midnight = (date: Date) => new Date(date.getFullYear(), date.getMonth(), date.getDate()).getTime();
  const days = Math.round((midnight(now) - midnight(at)) / DAY_MS);
  const time = `${two(at.getHours())}:${two(at.getMinutes())}`;
  if (days === 0) return `Today ${time}`;
  if (days === 1) return `Yesterday ${time}`;
  const year = at.getFullYear() === now.getFullYear() ? "" : ` ${at.getFullYear()}`;
  return `${at.getDate()} ${MONTHS[at.getMonth()]}${year} ${time}`;
}

const MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"] as const;

function two(n: number): string {
  return String(n).padStart(2, "0");
}

/** What is remarkable about a recording: a word or two, and what that means. */
export interface Mark {
  readonly text: string;
  readonly reason: string;
  /** Something is lost or wrong. */
  readonly bad: boolean;
}

export function marksOf(row: Recording, running: boolean): Mark[] {
  const { complete, recovered, gaps, restarts, imported, part_of, problem, profile, bookmarks } = row;
  const cut = !running && !complete && !recovered && problem === "";
  const marks: (Mark | false)[] = [
    running && mark("recording now", "It is being written."),
    problem !== "" && mark("problem", problem, true),
    recovered &&
      mark("recovered", "Its writer was killed; the file was mended and holds what was written.", true),
    cut && mark("cut short", "Its writer was killed: the file is readable up to its last batch.", true),
    gaps > 0 && mark(`${gaps} ticks missing`, holesText(row), true),
    restarts.length > 0 && mark("rig restarted", restartsText(row), true),
    imported && mark("imported", "Made elsewhere: time, x and y alone."),
    bookmarks.length > 0 &&
      mark(bookmarks.length === 1 ? "1 bookmark" : `${bookmarks.length} bookmarks`, bookmarksText(row)),
    part_of !== "" && mark("part", `It goes on the recording ${part_of}.`),
    profile === "full" && !imported && problem === "" && mark("full", "Every number of every tick as it is."),
  ];
  return marks.filter((one) => one !== false);
}

function mark(text: string, reason: string, bad = false): Mark {
  return { text, reason, bad };
}

/** When, and as what. */
function bookmarksText({ bookmarks }: Recording): string {
  return bookmarks.map(({ n, t, label }) => `${label === "" ? n : label} at ${t.toFixed(1)} s`).join(", ");
}

const HOLES_SHOWN = 3;

/** Where ticks are missing. */
function holesText({ gaps, holes }: Recording): string {
  const places = holes.slice(0, HOLES_SHOWN).map(({ after, ticks }) => `${ticks} after tick ${after}`);
  const rest = holes.length > HOLES_SHOWN ? [`${holes.length - HOLES_SHOWN} more holes`] : [];
  return `${gaps} ticks are not in the file: ${[...places, ...rest].join(", ")}.`;
}

/** How long the rig was away. */
function restartsText({ restarts }: Recording): string {
  const places = restarts
    .slice(0, HOLES_SHOWN)
    .map(({ after, seconds }) => `after tick ${after}, ${seconds.toFixed(1)} s without ticks`);
  return `The rig restarted: ${places.join("; ")}.`;
}
