import { expect, test } from "vitest";
import { ALARM_BOUNDS } from "../api/bounds";
import type { AlarmLimits } from "../api/types";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Operations } from "../operate/operations";
import { Store } from "../ui/store";
import { Alarms } from "./alarms";

const FIRST = Object.fromEntries(
  Object.entries(ALARM_BOUNDS).map(([name, bounds]) => [name, bounds.default]),
) as unknown as AlarmLimits;

test("two limits that are changed one right after the other both stay", async () => {
  const page = new Store<Page>({ ...EMPTY_PAGE, alarms: FIRST });
  const kept: AlarmLimits[] = [];
  const alarms = new Alarms(page, new Operations(page, () => undefined), {
    read: () => Promise.resolve(FIRST),
    reset: () => Promise.resolve(FIRST),
    keep: async (limits) => {
      await new Promise((resolve) => setTimeout(resolve, kept.length === 0 ? 20 : 1)); // the first answer comes last
      kept.push(limits);
      return limits;
    },
  });
  const change = (colour: "amber" | "red", value: number) =>
    alarms.keep("not changed", (now) => ({ ...now, round_trip: { ...now.round_trip, [colour]: value } }));
  await Promise.all([change("amber", 1e-5), change("red", 2e-5), change("amber", 1e-5)]);
  expect(page.get().alarms?.round_trip).toEqual({ amber: 1e-5, red: 2e-5 });
  expect(kept.at(-1)).toEqual(page.get().alarms);
});
