import type {
  AlarmLimits,
  Bookmark,
  Cause,
  LogEntry,
  FirstModeState,
  Health,
  Lease,
  MacroState,
  Mode,
  People,
  Profile,
  RecordingState,
  ReferenceInfo,
  ReferencePath,
  RigInfo,
  RunResult,
  RunState,
  Session,
  Settings,
  Workspace,
} from "../api/types";
import { useService } from "../ui/services";
import { Store, useStore } from "../ui/store";
import type { ErrorOf } from "./telemetry";

/** What became of the last E-STOP, for the operator. */
export interface StopNews {
  readonly phase: "sent" | "arrived" | "lost";
  readonly text: string;
}

export interface Marked extends Bookmark {
  /** Id of its recording: it may have ended before the label is typed. */
  readonly recording: string;
}

export interface LogLine extends LogEntry {
  readonly key: number;
}

/** Everything that React controls show. It changes at human speed; the 60 Hz stream is in `Live`. */
export interface Page {
  readonly view: "live" | "review" | "wall";
  /** Only the stops act until someone unlocks the page. */
  readonly locked: boolean;
  /** The list of keys is open. */
  readonly help: boolean;
  /** Null once it is no news. */
  readonly stop: StopNews | null;
  /** The recording that is open in Review. */
  readonly reviewed: string | null;
  /** Those that are compared there. */
  readonly compared: readonly string[];
  readonly session: "unknown" | "absent" | "present";
  readonly online: boolean;
  /** The live connection is open, and nothing comes by it: the network or the server, whatever the rig does. */
  readonly unheard: boolean;
  /** Why the server does not take this page in, "" where it does or does not answer. */
  readonly shutOut: string;
  readonly rigLive: boolean;
  /** Actuator with which the rig was told to start; "" once it is seen, and where no one asked for another. */
  readonly starting: string;
  /** My session's name and role, and whether others can read along. */
  readonly me: Omit<Session, "lease">;
  readonly lease: Lease;
  readonly people: People;
  readonly settings: Settings | null;
  readonly recording: RecordingState;
  readonly health: Health | null;
  /** From where on my health figures are amber and red; null before the server said so. */
  readonly alarms: AlarmLimits | null;
  readonly rig: RigInfo | null;
  readonly workspace: Workspace | null;
  /** The menu for the rig's actuator. */
  readonly references: readonly ReferenceInfo[];
  /** Name of the reference chosen in the menu. */
  readonly chosen: string | null;
  /** Its points, drawn on the plan. */
  readonly reference: ReferencePath | null;
  /** The run under way, or how the last one ended. */
  readonly run: RunState | null;
  /** Of the last run that ended. */
  readonly result: RunResult | null;
  /** The macro under way, or how the last one ended. */
  readonly macro: MacroState | null;
  /** The measurement of the first mode, or how the last one ended. */
  readonly firstMode: FirstModeState | null;
  readonly mode: Mode | null;
  readonly cause: Cause;
  /** Who pressed the E-STOP in which the rig is, "" where that is not known. */
  readonly stoppedBy: string;
  /** Whose sign of presence the rig missed when it last held for lack of one, and why; "" before. */
  readonly missed: string;
  readonly saturated: boolean;
  readonly reachable: boolean;
  readonly errorOf: ErrorOf;
  readonly log: readonly LogLine[];
  /** Why the last touch of the target did nothing; shown on the plan. */
  readonly hint: string;
  /** Name of the gamepad that is heard, "" without one. */
  readonly gamepad: string;
  /** The bookmark that was set just now, whose label may be typed, and in which recording; null once that is done. */
  readonly marked: Marked | null;
  /** How far one step lets the paused twin go on [ticks]. */
  readonly step: number;
  /** Name that the next recording gets. */
  readonly recordingName: string;
  /** What the panel of a rig of devices shows. */
  readonly rigSection: "drivers" | "file" | "commissioning";
  /** How much of every tick the next recording keeps. */
  readonly recordingProfile: Profile;
}

export const EMPTY_PAGE: Page = {
  view: "live",
  locked: false,
  help: false,
  stop: null,
  reviewed: null,
  compared: [],
  session: "unknown",
  online: false,
  unheard: false,
  shutOut: "",
  rigLive: false,
  starting: "",
  me: { name: "", role: "viewer", unprotected: false },
  lease: { held: false, mine: false, holder: "", clutch: false, lost: "" },
  people: { holder: "", asking: [], others: [], waiting: false },
  settings: null,
  recording: {
    recording: false,
    id: "",
    seconds: 0,
    rows: 0,
    gaps: 0,
    problem: "",
    origin: 0,
    bookmarks: [],
  },
  health: null,
  alarms: null,
  rig: null,
  workspace: null,
  references: [],
  chosen: null,
  reference: null,
  run: null,
  result: null,
  macro: null,
  firstMode: null,
  mode: null,
  cause: 0,
  stoppedBy: "",
  missed: "",
  saturated: false,
  reachable: true,
  errorOf: "none",
  log: [],
  hint: "",
  gamepad: "",
  marked: null,
  step: 10,
  recordingName: "",
  rigSection: "drivers",
  recordingProfile: "standard",
};

const LOG_KEPT = 1000;
let lines = 0;

/** The log with these lines too, newest first. A server that tells its log again adds only what was missed. */
export function withLines(log: readonly LogLine[], events: readonly LogEntry[]): readonly LogLine[] {
  const known = new Set(log.map(identity));
  const fresh = events.filter((event) => !known.has(identity(event)));
  if (fresh.length === 0) return log;
  const keyed = fresh.map((event) => ({ ...event, key: (lines += 1) }));
  const later = inOrder([...log.slice(0, 1), ...keyed]); // as almost always: a thousand lines are not sorted for one
  const all = [...keyed.reverse(), ...log];
  const sorted = later ? all : all.toSorted((a, b) => Date.parse(b.time) - Date.parse(a.time));
  return countedUp(sorted).slice(0, LOG_KEPT);
}

/** Of the lines that count one subject up, newest first, only the newest. */
function countedUp(log: readonly LogLine[]): readonly LogLine[] {
  const counts = new Map<string, number>();
  return log.filter(({ subject, count }) => {
    if (subject === "") return true;
    const replaced = count === (counts.get(subject) ?? 1) - 1;
    counts.set(subject, count);
    return !replaced;
  });
}

function inOrder(events: readonly LogEntry[]): boolean {
  const times = events.map(({ time }) => Date.parse(time));
  return times.every((time, i) => i === 0 || time >= (times[i - 1] ?? time));
}

function identity({ time, text }: LogEntry): string {
  return `${time} ${text}`;
}

/** Which link is silent, the nearest to this page first: what lies behind it cannot be judged. */
export type Silence = "none" | "server" | "rig";

export function silenceOf({
  online,
  unheard,
  rigLive,
}: Pick<Page, "online" | "unheard" | "rigLive">): Silence {
  if (!online || unheard) return "server";
  return rigLive ? "none" : "rig";
}

type Operating = Pick<Page, "lease" | "people">;

/** Whether who operates, another than I, has a page open. */
export function isOperatorHere({ people }: Operating): boolean {
  return people.others.some(({ tag }) => tag === people.holder);
}

/** Who operates, as others see it; a person whose page is gone only holds control until it lapses. */
export function operatorText({ lease, people }: Operating): string {
  return isOperatorHere({ lease, people })
    ? `${lease.holder} operates`
    : `${lease.holder} has closed the page; control is free soon`;
}

/** `next`, or `old` itself when nothing in it changed: controls that follow it then stay as they are. */
export function keep<T>(old: T, next: T): T {
  return JSON.stringify(old) === JSON.stringify(next) ? old : next;
}

export class PageStore extends Store<Page> {
  constructor() {
    super(EMPTY_PAGE);
  }
}

/** Follow a part of the page's state; `select` gives a primitive or an object that is kept. */
export function usePage<S>(select: (page: Page) => S): S {
  return useStore(useService(PageStore), select);
}
