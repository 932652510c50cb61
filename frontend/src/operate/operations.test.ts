import { expect, test } from "vitest";
import { EMPTY_PAGE } from "../live/page";
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
