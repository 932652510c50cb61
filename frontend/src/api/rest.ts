import createClient from "openapi-fetch";
import type { paths } from "./schema";

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

/** The server's REST with the paths and types of its own OpenAPI document; raises Refusal or Unreachable. */
export const api = createClient<paths>({ credentials: "same-origin", fetch: accepted });

/** When the newest answer to a request for a change was given, by the server's own clock [s]. */
let newest = -Infinity;

/** Whether what was read at `time` [s] is older than an answer that is known: it may come after it all the same. */
export const isOutdated = (time: number) => time <= newest;

/** Another server may have another clock. */
export function forgetAnswers(): void {
  newest = -Infinity;
}

/** What the server answered; what it refuses has been raised already. */
export async function dataOf<T>(asked: Promise<{ data?: T }>): Promise<T> {
  return (await asked).data as T;
}

/** Fills `{name}` of a path. */
export const named = (name: string) => ({ params: { path: { name } } });

/** A file goes as it is: OpenAPI knows its text only as a string. */
export function asCsv(file: File) {
  return { body: "", bodySerializer: () => file, headers: { "content-type": "text/csv" } };
}

/** An E-STOP goes out by this: nothing may be awaited before `fetch`, here or in a middleware of `api`. */
async function accepted(request: Request): Promise<Response> {
  const response = await fetch(request).catch((error: unknown) => {
    throw new Unreachable(`The server did not answer (${String(error)})`);
  });
  if (response.ok) {
    const time = response.headers.get("tendril-time");
    if (request.method !== "GET" && time !== null) newest = Math.max(newest, Number(time));
    return response;
  }
  const answer: unknown = await response.json().catch(() => null);
  const { status, statusText } = response;
  throw new Refusal(status, refusalText(answer, statusText), request.method !== "GET");
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
  const place = path
    .filter((part) => !UNSAID.has(part))
    .map(inWords)
    .join(" ");
  const text = String(item.msg)
    .replace(/^(Input|String|List|Tuple|Value|Dictionary) should /, "must ")
    .replace(/^Field required$/, "is missing");
  const [between, but] = text.startsWith("must ")
    ? [" ", ", not "]
    : text === "is missing"
      ? [" ", ""]
      : [": ", "; got "];
  const value = "input" in item && but !== "" ? but + JSON.stringify(item.input) : "";
  return `${place}${place === "" ? "" : between}${text}${value}`;
}

/** Parts of a field's path that say nothing to who typed into it. */
const UNSAID = new Set<unknown>(["body", "changes", "path", "query"]);

/** A place in a list counts from one. */
function inWords(part: unknown): string {
  return typeof part === "number" ? `(value ${part + 1})` : String(part);
}
