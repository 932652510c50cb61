import { expect, test } from "vitest";
import type { Macro, MacroState, MacroStep } from "../../api/types";
import { EMPTY_PAGE, type Page } from "../../live/page";
import { Store } from "../../ui/store";
import { endText, KINDS, Macros, moved, stepText, titleOf, whyNotSaved, type Draft } from "./macros";

const ARM: MacroStep = { do: "arm" };
const HOLD: MacroStep = { do: "hold" };
const WAIT: MacroStep = { do: "wait", seconds: 3 };
const state: MacroState = { name: "warm-up", learning: false, by: "ivy", state: "running", step: 2, steps: 5, doing: "wait 3 s", reason: "" }; // prettier-ignore

/** A page beside a server that keeps macros. */
function desk(kept: readonly Macro[] = []) {
  const page = new Store<Page>(EMPTY_PAGE);
  const asked: string[] = [];
  const shown: string[] = [];
  let list = [...kept];
  const macros = new Macros(
    page,
    {
      attempt: async (title, action) => {
        await action().catch((error: unknown) => shown.push(`${title}: ${String(error)}`));
      },
      notify: (_, title, text) => shown.push(`${title}: ${text}`),
    },
    {
      list: () => Promise.resolve(list),
      keep: (name, steps) => {
        asked.push(`keep ${name}`);
        list = [...list.filter((macro) => macro.name !== name), { name, steps: [...steps] }];
        return Promise.resolve(list);
      },
      remove: (name) => {
        asked.push(`remove ${name}`);
        list = list.filter((macro) => macro.name !== name);
        return Promise.resolve(list);
      },
      run: (name) => (asked.push(`run ${name}`), Promise.resolve(state)),
      stop: () => Promise.reject(new Error("no macro runs")),
    },
  );
  return { page, asked, shown, macros };
}

test("steps are moved one place, and not beyond the ends", () => {
  const steps = [ARM, WAIT, HOLD];
  expect(moved(steps, 0, 1)).toEqual([WAIT, ARM, HOLD]);
  expect(moved(steps, 2, -1)).toEqual([ARM, HOLD, WAIT]);
  expect([moved(steps, 0, -1), moved(steps, 2, 1)]).toEqual([steps, steps]);
});

test("a macro is written, kept, renamed and dropped; under a new name it is kept before the old one goes", async () => {
  const { asked, macros } = desk([{ name: "old", steps: [ARM] }]);
  await macros.learn();
  macros.edit(macros.store.get().list[0]);
  macros.change({ name: " new ", steps: [ARM, WAIT] });
  await macros.save();
  expect(asked).toEqual(["keep new", "remove old"]);
  expect(macros.store.get()).toEqual({ list: [{ name: "new", steps: [ARM, WAIT] }], draft: null });
  macros.edit(null);
  expect(macros.store.get().draft).toEqual({ was: null, name: "", steps: [ARM] });
  macros.drop();
  await macros.save();
  expect(asked).toHaveLength(2);
});

test("what cannot be saved says why", () => {
  const draft: Draft = { was: null, name: "warm-up", steps: [ARM] };
  const list = [{ name: "other", steps: [ARM] }];
  expect(whyNotSaved(draft, list)).toBeNull();
  expect(whyNotSaved({ ...draft, name: "a/b" }, list)).toContain("Give it a name");
  expect(whyNotSaved({ ...draft, name: "other" }, list)).toBe("There is a macro of this name already");
  expect(whyNotSaved({ ...draft, was: "other", name: "other" }, list)).toBeNull();
  expect(whyNotSaved({ ...draft, steps: [] }, list)).toBe("It has no step yet");
  expect(whyNotSaved({ ...draft, steps: [ARM, KINDS.drawing[1]] }, list)).toBe("Choose what step 2 takes");
});

test("who saw it run is told how it ended, once, and a refusal is shown", async () => {
  const { page, shown, macros } = desk();
  const ended: MacroState = { ...state, state: "ended", reason: "HOLD, asked for by ivy" };
  page.patch({ macro: ended });
  expect(shown, "before this page was opened").toEqual([]);
  page.patch({ macro: state });
  page.patch({ macro: ended });
  page.patch({ macro: { ...ended } });
  await macros.stop();
  expect(shown).toEqual([
    "Macro warm-up ended: ended at step 2 of 5, wait 3 s: HOLD, asked for by ivy",
    "Macro not stopped: Error: no macro runs",
  ]);
  expect([stepText(state), endText({ ...state, state: "done" })]).toEqual(["step 2 of 5, wait 3 s", "done"]);
});

test("what is learned is not called a macro", () => {
  expect(titleOf(state)).toBe("Macro warm-up");
  const learning = { ...state, name: "vu", learning: true };
  expect([titleOf(learning), stepText(learning)]).toEqual(["Learning vu", "repeat 2 of 5"]);
});
