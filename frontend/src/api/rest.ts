import type {
  AlarmLimits,
  CommandBody,
  CommandReply,
  DrawingBody,
  DrawingInfo,
  DrawingPlan,
  Lease,
  LoopHealth,
  PlotLayout,
  Preview,
  PreviewBody,
  Profile,
  Recording,
  RecordingState,
  ReferenceInfo,
  ReferencePath,
  RunBody,
  RunState,
  Session,
  Settings,
  TextPath,
  Workspace,
} from "./types";

/** The server refused; `message` is its own text. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    message: string,
    /** The server wrote it into the log. */
    readonly logged: boolean,
  ) {
    super(message);
  }
}

/** The server did not answer at all. */
export class Unreachable extends Error {}

export type Method = "GET" | "POST" | "PUT" | "PATCH" | "DELETE";

/** What the server answered, with what it says beside it. */
export interface Answer<T> {
  readonly body: T;
  readonly headers: Headers;
}

/** Ask the server; raises Refusal with its own words, or Unreachable. */
export async function call<T>(method: Method, path: string, body?: unknown): Promise<T> {
  return (await ask<T>(method, path, body)).body;
}

/** As `call`, with the headers too. A file goes as it is, anything else as JSON. */
export async function ask<T>(
  method: Method,
  path: string,
  body?: unknown,
  how: RequestInit = {},
): Promise<Answer<T>> {
  const init: RequestInit = { ...how, method, credentials: "same-origin" };
  if (body instanceof File) {
    init.body = body;
    init.headers = { "content-type": "text/csv" };
  } else if (body !== undefined) {
    init.body = JSON.stringify(body);
    init.headers = { "content-type": "application/json" };
  }
  const response = await fetch(path, init).catch((error: unknown) => {
    throw new Unreachable(`The server did not answer (${String(error)})`);
  });
  const answer: unknown = await response.json().catch(() => null);
  if (!response.ok)
    throw new Refusal(response.status, refusalText(answer, response.statusText), method !== "GET");
  return { body: answer as T, headers: response.headers };
}

/** The sentence in an error body: `{detail: "..."}`, FastAPI's list of field errors, or a refused CommandReply. */
export function refusalText(body: unknown, fallback: string): string {
  const detail = typeof body === "object" && body !== null && "detail" in body ? body.detail : body;
  if (typeof detail === "string" && detail !== "") return detail;
  if (Array.isArray(detail)) return detail.map(fieldError).join("; ");
  if (typeof detail === "object" && detail !== null) return refusalText(detail, JSON.stringify(detail));
  return fallback || "refused without a reason";
}

function fieldError(item: unknown): string {
  if (typeof item !== "object" || item === null || !("msg" in item)) return JSON.stringify(item);
  const path: unknown[] = "loc" in item && Array.isArray(item.loc) ? item.loc : [];
  const place = path.filter((part) => part !== "body" && part !== "changes").join(".");
  const value = "input" in item ? ` (got ${JSON.stringify(item.input)})` : "";
  return `${place}: ${String(item.msg)}${value}`;
}

/** E-STOP goes before what else the browser fetches, and goes on when the page is closed. */
const URGENT: RequestInit = { priority: "high", keepalive: true };

export const rest = {
  stop: async () => (await ask<CommandReply>("POST", "/api/command", { request: "e_stop" }, URGENT)).body,
  login: (token: string) => call<Session>("POST", "/api/session", { token }),
  session: () => call<Session>("GET", "/api/session"),
  /** Refused where the live socket would be: a browser hides why. */
  mayLookOn: () => call<null>("GET", "/api/live"),
  takeLease: () => call<Lease>("POST", "/api/lease"),
  releaseLease: () => call<Lease>("DELETE", "/api/lease"),
  askForLease: () => call<Lease>("POST", "/api/lease/request"),
  withdrawRequest: () => call<Lease>("DELETE", "/api/lease/request"),
  refuseRequest: (tag: string) => call<Lease>("POST", "/api/lease/refuse", { tag }),
  handOver: (tag: string) => call<Lease>("POST", "/api/lease/hand-over", { tag }),
  takeOver: (tag: string) => call<Lease>("POST", "/api/lease/take-over", { tag }),
  setClutch: (clutch: boolean) => call<Lease>("PATCH", "/api/lease", { clutch }),
  loopHealth: () => call<LoopHealth>("GET", "/api/health/loop"),
  alarms: () => call<AlarmLimits>("GET", "/api/alarms"),
  keepAlarms: (limits: AlarmLimits) => call<AlarmLimits>("PUT", "/api/alarms", limits),
  resetAlarms: () => call<AlarmLimits>("DELETE", "/api/alarms"),
  command: (body: CommandBody) => call<CommandReply>("POST", "/api/command", body),
  changeSettings: (changes: Partial<Settings>) => call<Settings>("PATCH", "/api/settings", { changes }),
  workspace: () => call<Workspace>("GET", "/api/workspace"),
  references: () => call<ReferenceInfo[]>("GET", "/api/references"),
  reference: (name: string) => call<ReferencePath>("GET", `/api/references/${encodeURIComponent(name)}`),
  planDrawing: (body: DrawingBody) => call<DrawingPlan>("POST", "/api/drawings/plan", body),
  textPath: (text: string, height: number) => call<TextPath>("POST", "/api/drawings/text", { text, height }),
  drawings: () => call<DrawingInfo[]>("GET", "/api/drawings"),
  drawing: (name: string) => call<DrawingBody>("GET", drawingUrl(name)),
  saveDrawing: (body: DrawingBody) => call<DrawingInfo>("PUT", drawingUrl(body.name), body),
  deleteDrawing: (name: string) => call<unknown>("DELETE", drawingUrl(name)),
  preview: (body: PreviewBody) => call<Preview>("POST", "/api/preview", body),
  run: (body: RunBody) => call<RunState>("POST", "/api/run", body),
  steerRun: (step: "pause" | "resume" | "stop") => call<RunState>("POST", `/api/run/${step}`),
  layouts: () => call<string[]>("GET", "/api/layouts"),
  layout: (name: string) => call<PlotLayout>("GET", `/api/layouts/${encodeURIComponent(name)}`),
  keepLayout: (name: string, layout: PlotLayout) =>
    call<PlotLayout>("PUT", `/api/layouts/${encodeURIComponent(name)}`, layout),
  forgetLayout: (name: string) => call<null>("DELETE", `/api/layouts/${encodeURIComponent(name)}`),
  startRecording: (name: string, profile: Profile) =>
    call<RecordingState>("POST", "/api/recordings", { name, profile }),
  stopRecording: () => call<Recording>("DELETE", "/api/recordings/current"),
};

/** Address of the saved drawing `name`; with ".csv" behind it, of its download. */
export function drawingUrl(name: string): string {
  return `/api/drawings/${encodeURIComponent(name)}`;
}

/** Address at which rerun's viewer gets the recording `id` of the server at `origin`. */
export function recordingUrl(origin: string, id: string): string {
  return `${origin}/api/recordings/${encodeURIComponent(id)}.rrd`;
}

/** Address of rerun's own viewer, showing the recording `id` of the server at `origin`; with null it shows nothing yet. */
export function viewerUrl(
  origin: string,
  id: string | null,
  theme: "dark" | "light",
  renderer: string | null,
): string {
  const query = new URLSearchParams();
  if (id !== null) query.set("url", recordingUrl(origin, id));
  if (renderer !== null) query.set("renderer", renderer);
  return `/rerun/?${query.toString()}&hide_welcome_screen&persist=0&theme=${theme}`;
}
