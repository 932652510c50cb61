import { expect, test } from "vitest";
import type { RunResult, Settings } from "../../api/types";
import { EMPTY_PAGE, type Page } from "../../live/page";
import { MODE } from "../../live/modes";
import { Store } from "../../ui/store";
import { Notices, type Leave } from "./notices";

/** A page someone looks away from, in a browser that answers `answer` when it is asked. */
function desk(answer: Leave = "granted", kept: string | null = null) {
  const page = new Store<Page>(EMPTY_PAGE);
  const storage = new Map<string, string>(kept === null ? [] : [["tendril-notices", kept]]);
  const now = { leave: kept === "on" ? answer : ("default" as Leave), away: true, asked: 0 };
  const shown: string[] = [];
  const notices = new Notices(
    page,
    {
      getItem: (key) => storage.get(key) ?? null,
      setItem: (key, value) => void storage.set(key, value),
      removeItem: (key) => void storage.delete(key),
    },
    {
      leave: () => now.leave,
      ask: () => {
        now.asked += 1;
        now.leave = answer;
        return Promise.resolve(answer);
      },
      show: (title, text) => shown.push(`${title} (${text})`),
      away: () => now.away,
    },
  );
  return { page, storage, now, shown, notices };
}

const settings = {} as Settings;
const result = (id: number) => ({ id, name: "circle", state: "done", reason: "" }) as RunResult;

test("no one is asked before a click, and nothing is shown without one", async () => {
  const { page, now, shown, notices } = desk();
  page.patch({ settings, mode: MODE.HOLD });
  page.patch({ mode: MODE.FAULT });
  expect([now.asked, shown.length]).toEqual([0, 0]);
  await notices.want(true);
  page.patch({ mode: MODE.HOLD });
  page.patch({ mode: MODE.E_STOP, cause: 1, stoppedBy: "ivy 3" });
  expect(now.asked).toBe(1);
  expect(shown).toEqual(["Tendril: E-STOP (by ivy 3)"]);
});

test("FAULT and the end of a run are told once, and neither is what was so before the page was opened", () => {
  const { page, shown } = desk("granted", "on");
  page.patch({ mode: MODE.FAULT });
  page.patch({ settings, result: result(7) });
  page.patch({ mode: MODE.VENTED });
  page.patch({ mode: MODE.FAULT, cause: 10 });
  page.patch({ result: result(8) });
  page.patch({ result: { ...result(8) } });
  expect(shown.map((text) => text.split(" (")[0])).toEqual(["Tendril: FAULT", "Tendril: circle done"]);
});

test("who looks at the page is told nothing twice", () => {
  const { page, now, shown } = desk("granted", "on");
  now.away = false;
  page.patch({ settings, mode: MODE.HOLD });
  page.patch({ mode: MODE.FAULT, result: result(1) });
  expect(shown).toEqual([]);
});

test("a browser that refuses leaves it off, now and after a reload; the choice is kept otherwise", async () => {
  const refused = desk("denied");
  await refused.notices.want(true);
  expect(refused.notices.store.get()).toEqual({ wanted: false, leave: "denied" });
  expect(refused.storage.get("tendril-notices")).toBe("off");
  const taken = desk();
  await taken.notices.want(true);
  expect(taken.storage.get("tendril-notices")).toBe("on");
  taken.notices.test();
  expect(taken.shown).toHaveLength(1);
});
