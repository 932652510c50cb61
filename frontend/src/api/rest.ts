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
