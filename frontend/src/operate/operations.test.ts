import { expect, test, vi } from "vitest";
import { api } from "../api/rest";
import type { Settings } from "../api/types";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Store } from "../ui/store";
import { Operations } from "./operations";

test("control that went with the connection is said, in a notice and in the log, with who operates now", () => {
  const page = new Store(EMPTY_PAGE);
  const said: string[] = [];
  const operations = new Operations(page, (level, title, text) => said.push(`${level}: ${title}: ${text}`));
  operations.leaseLost("");
  operations.leaseLost("ivy 3");
  expect(said[0]).toMatch(/^warning: You no longer operate: .*server restarted: take it again/);
  expect(said[1]).toContain("ivy 3 operates now");
  expect(page.get().log.map(({ level }) => level)).toEqual(["warning", "warning"]);
  expect(page.get().log.at(-1)?.text).toContain("take it again");
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
