import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { FromBrowser } from "../../api/types";
import { Live } from "../../live/live";
import { EMPTY_PAGE, type Page } from "../../live/page";
import { MODE } from "../../live/modes";
import { Store } from "../../ui/store";
import { Operations } from "../operations";
import { TargetControl } from "./targetControl";
import { handleOf, type RigTarget } from "./handle";

// Moves go out every 4 ms at most: a machine that stands still for longer between two of them sends both.
beforeEach(() => vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "performance"] }));
afterEach(() => vi.useRealTimers());

test("letting go is said once, after the last move; with the clutch on no move comes after it", () => {
  const sent: FromBrowser[] = [];
  const lease = { held: true, mine: true, holder: "me", clutch: true, lost: "" };
  const page = new Store<Page>({ ...EMPTY_PAGE, online: true, rigLive: true, mode: MODE.HOLD, lease });
  const send = (message: FromBrowser) => sent.push(message) > 0;
  const targetControl = new TargetControl(new Live(), page, new Operations(page, () => undefined), { send });
  targetControl.release();
  expect(sent).toEqual([]);
  targetControl.move([0.1, 0], true, true);
  targetControl.move([0.2, 0], false, true);
  targetControl.release();
  targetControl.release();
  expect(sent.map(({ type }) => type)).toEqual(["target", "release"]);
});

const rig: RigTarget = { mode: MODE.FOLLOW, target: [0.1, 0.1], reference: [0.09, 0.1], tip: [0.08, 0.1] };

test("a moved handle is hollow until the rig echoes it", () => {
  const wish = { point: [0.2, 0.1], at: 0, held: true } as const;
  expect(handleOf(wish, rig, 0)).toEqual({ point: [0.2, 0.1], acknowledged: false, movable: true });
  expect(handleOf(wish, { ...rig, target: [0.2, 0.1] }, 0)?.acknowledged).toBe(true);
});

test("a wish that the rig did not take gives way to where the rig is", () => {
  const wish = { point: [0.2, 0.1], at: 0, held: false } as const;
  expect(handleOf(wish, rig, 1000)?.point).toEqual([0.1, 0.1]);
  expect(handleOf(wish, { ...rig, mode: MODE.HOLD }, 1000)).toMatchObject({
    point: [0.09, 0.1],
    acknowledged: false,
  });
});

test("while vented the handle rests on the tip and cannot be moved", () => {
  expect(handleOf(null, { ...rig, mode: MODE.VENTED }, 0)).toMatchObject({
    point: [0.08, 0.1],
    movable: false,
  });
});

test("when the rig falls to HOLD in the middle of a drag, the drag moves nothing until a new press", () => {
  const lease = { held: true, mine: true, holder: "me", clutch: false, lost: "" };
  const page = new Store({ ...EMPTY_PAGE, online: true, rigLive: true, lease });
  const targetControl = new TargetControl(new Live(), page, new Operations(page, () => undefined), {
    send: () => true,
  });
  page.patch({ mode: MODE.HOLD });
  expect(targetControl.move([0.1, 0], true, true)).toBe(true);
  expect(targetControl.move([0.11, 0], false, true)).toBe(true);
  page.patch({ mode: MODE.FOLLOW });
  expect(targetControl.move([0.12, 0], false, true)).toBe(true);
  page.patch({ mode: MODE.HOLD });
  expect(targetControl.move([0.13, 0], false, true)).toBe(false);
  expect(page.get().hint).toContain("press again");
  expect(targetControl.move([0.13, 0], true, true)).toBe(true);
  page.patch({ mode: MODE.VENTED });
  expect(targetControl.move([0.14, 0], true, true)).toBe(false);
  expect(page.get().hint).toBe("Arm first");
});
