import { expect, test, vi } from "vitest";
import { api, asCsv, Refusal, refusalText, dataOf, Unreachable } from "./rest";

/** Node has no page whose address would complete a path. */
const baseUrl = "http://rig";

/** The server answers once, or not at all; what it was asked. */
function server(answer: Response | Promise<Response>) {
  const fetch = vi.fn<(request: Request) => Promise<Response>>(() => Promise.resolve(answer));
  vi.stubGlobal("fetch", fetch);
  return () => fetch.mock.calls[0][0];
}

test("an E-STOP is on its way before anything else can run, and outlives the page", async () => {
  const asked = server(Response.json({ accepted: true }));
  const answer = dataOf(api.POST("/api/command", { baseUrl, keepalive: true, body: { request: "e_stop" } }));
  const { url, method, credentials, keepalive } = asked();
  expect([url, method, credentials, keepalive]).toEqual([
    "http://rig/api/command",
    "POST",
    "same-origin",
    true,
  ]);
  expect(await asked().json()).toEqual({ request: "e_stop" });
  expect(await answer).toEqual({ accepted: true });
});

test("a file goes as it is", async () => {
  const asked = server(new Response(null, { status: 204 }));
  await api.POST("/api/drawings/import", { baseUrl, ...asCsv(new File(["x,y\n"], "a.csv")) });
  expect([asked().headers.get("content-type"), await asked().text()]).toEqual(["text/csv", "x,y\n"]);
});

test("what the server refuses is raised in its words, with whether it stands in the log", async () => {
  server(Response.json({ detail: "sign in first" }, { status: 401 }));
  const refused = await dataOf(api.GET("/api/session", { baseUrl })).catch((error: unknown) => error);
  expect(refused).toEqual(new Refusal(401, "sign in first", false));
  server(new Response("<html>", { status: 502, statusText: "Bad Gateway" }));
  await expect(api.POST("/api/lease", { baseUrl })).rejects.toMatchObject({
    message: "Bad Gateway",
    logged: true,
  });
});

test("a server that does not answer is told from one that refuses", async () => {
  server(Promise.reject(new TypeError("Failed to fetch")));
  const unheard = api.GET("/api/gains", { baseUrl });
  await expect(unheard).rejects.toThrow(Unreachable);
  await expect(unheard).rejects.toThrow("The server did not answer (TypeError: Failed to fetch)");
});

test("a refusal reads as the server's own sentence, whatever its shape", () => {
  expect(refusalText({ detail: "ivy operates now" }, "Conflict")).toBe("ivy operates now");
  const reply = { n: 4, accepted: false, mode: 0, cause: 13, detail: "HOLD is not possible in VENTED" };
  expect(refusalText(reply, "Conflict")).toBe("HOLD is not possible in VENTED");
  expect(refusalText(null, "Bad Gateway")).toBe("Bad Gateway");
});

test("a malformed body reads as field, reason and value", () => {
  const detail = [
    { loc: ["body", "changes", "K_P", 0], msg: "Input should be less than or equal to 5", input: 12 },
  ];
  expect(refusalText({ detail }, "")).toBe("K_P (value 1) must be less than or equal to 5, not 12");
  const tag = { loc: ["body", "tags", 0], msg: "a tag has no blanks", input: "a b" };
  expect(refusalText({ detail: [tag] }, "")).toBe('tags (value 1): a tag has no blanks; got "a b"');
  const missing = { loc: ["body", "request"], msg: "Field required", input: {} };
  expect(refusalText({ detail: [missing] }, "")).toBe("request is missing");
});
