import { expect, test, vi } from "vitest";
import { api } from "../api/rest";
import type { Settings } from "../api/types";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Store } from "../ui/store";
import { Operations } from "./operations";

test("control that went is said with its reason, in a notice, on the plan and in the log", () => {
  const page = new Store(EMPTY_PAGE);
  const said: string[] = [];
  const operations = new Operations(page, (level, title, text) => said.push(`${level}: ${title}: ${text}`));
  const gone = { held: false, mine: false, holder: "", clutch: false, lost: "" };
  const lapsed = "nothing was heard of the page for 5 s";
  operations.leaseChanged(gone, "");
  operations.leaseChanged({ ...gone, lost: lapsed }, "the browser stood still for 7 s");
  operations.leaseChanged(
    { ...gone, held: true, holder: "ivy 3", lost: "ivy 3 took control over" },
    "the browser stood still for 4 s",
  );
  expect(said).toEqual([
    "warning: You no longer operate: the server was started again: take control to go on",
    "warning: You no longer operate: nothing was heard of the page for 5 s (the browser stood still for 7 s): take control to go on",
    "warning: You no longer operate: ivy 3 took control over: ivy 3 operates now",
  ]);
  expect(page.get().log.map(({ level }) => level)).toEqual(["warning", "warning", "warning"]);
  expect(page.get().hint).toBe("Control lost: ivy 3 took control over");
});

test("two quick changes of one pair are both kept: the second is made of what the first left", async () => {
  const settings = { K_P: [0.1, 0.1] } as unknown as Settings;
  const page = new Store<Page>({ ...EMPTY_PAGE, settings });
  const patched = vi.spyOn(api, "PATCH").mockImplementation(((_: string, { body }: { body: { changes: object } }) =>
    new Promise((answer) => setTimeout(() => { answer({ data: { ...page.get().settings, ...body.changes } }); }, 5))) as never); // prettier-ignore
  const operations = new Operations(page, () => undefined);
  const one = operations.changeSettings("x", ({ K_P }) => ({ K_P: [0.2, K_P[1]] }));
  const two = operations.changeSettings("y", ({ K_P }) => ({ K_P: [K_P[0], 0.3] }));
  await Promise.all([one, two]);
  expect(page.get().settings?.K_P).toEqual([0.2, 0.3]);
  expect(patched).toHaveBeenCalledTimes(2);
  patched.mockRestore();
});

test("a change that is refused does not keep the next one from being sent", async () => {
  const page = new Store<Page>({ ...EMPTY_PAGE, settings: { law: 4 } as Settings });
  const patched = vi
    .spyOn(api, "PATCH")
    .mockRejectedValueOnce(new Error("K_P = 12 is outside [0, 5]"))
    .mockResolvedValueOnce({ data: { law: 3 } } as never);
  const said: string[] = [];
  const operations = new Operations(page, (_, title) => said.push(title));
  await Promise.all([operations.changeSettings("K_P not changed", {}), operations.changeSettings("Law", {})]);
  expect(said).toEqual(["K_P not changed"]);
  expect(page.get().settings?.law).toBe(3);
  patched.mockRestore();
});
