import { expect, test } from "vitest";
import { bytes, clock, DASH, kilopascals, microseconds, millimetres, percent } from "./format";
import { KeyMap, type Press } from "../operate/target/keys";
import { MODE } from "../rig/modes";
import { OnTime } from "../live/onTime";
import { keep } from "../live/page";
import { whyNot, type Control, type Situation } from "../operate/permission";
import { Trail } from "../live/trail";

const press = (key: string, more: Partial<Press> = {}): Press => ({
  ...{ key, shiftKey: false, ctrlKey: false, altKey: false, metaKey: false, repeat: false },
  ...more,
});

test("Esc holds, and twice within a second it is an E-STOP, even in a text field", () => {
  const keys = new KeyMap();
  expect(keys.press(press("Escape"), "text", 0)).toEqual({ kind: "hold" });
  expect(keys.press(press("Escape"), "text", 900)).toEqual({ kind: "e_stop" });
  expect(keys.press(press("Escape"), "page", 1000)).toEqual({ kind: "hold" });
  expect(keys.press(press("Escape"), "page", 2100)).toEqual({ kind: "hold" });
});

test("a held Esc key is one press", () => {
  const keys = new KeyMap();
  keys.press(press("Escape"), "page", 0);
  expect(keys.press(press("Escape", { repeat: true }), "page", 40)).toBeNull();
});

test("arrows move the target by 1, 10 or 0.1 mm, only while no control wants them; a repeat is not a fresh press", () => {
  const keys = new KeyMap();
  expect(keys.press(press("ArrowUp"), "page", 0)).toMatchObject({
    kind: "nudge",
    dx: 0,
    dy: 1e-3,
    fresh: true,
  });
  expect(keys.press(press("ArrowLeft", { shiftKey: true }), "page", 0)).toMatchObject({ dx: -1e-2 });
  expect(keys.press(press("ArrowLeft", { ctrlKey: true }), "page", 0)).toMatchObject({ dx: -1e-4 });
  expect(keys.press(press("ArrowUp", { repeat: true }), "page", 0)).toMatchObject({ fresh: false });
  expect(keys.press(press("ArrowUp"), "widget", 0)).toBeNull();
});

test("letters are keys of the page unless they are being typed or belong to the browser", () => {
  const keys = new KeyMap();
  expect(keys.press(press("f"), "widget", 0)).toEqual({ kind: "follow" });
  expect(keys.press(press("f"), "text", 0)).toBeNull();
  expect(keys.press(press("r", { ctrlKey: true }), "page", 0)).toBeNull();
  expect(keys.press(press("?", { shiftKey: true }), "page", 0)).toEqual({ kind: "help" });
});

test("numbers carry units, and a missing one is a dash", () => {
  expect(millimetres(0.01234)).toBe("12.3 mm");
  expect(millimetres(-0.00001)).toBe("0.0 mm");
  expect(millimetres(NaN)).toBe(DASH);
  expect(millimetres(null)).toBe(DASH);
  expect(kilopascals(118_200)).toBe("118 kPa");
  expect(percent(0.99981)).toBe("99.98 %");
  expect(microseconds(12_340)).toBe("12.3 µs");
  expect([clock(72.9), clock(3723)]).toEqual(["1:12", "1:02:03"]);
  expect([bytes(512_000), bytes(1.8e9)]).toEqual(["512 kB", "1.80 GB"]);
});

const operating: Situation = {
  ...{
    online: true,
    rigLive: true,
    mode: MODE.VENTED,
    mine: true,
    held: true,
    holder: "me",
    recording: false,
    role: "operator",
  },
};
const CONTROLS: readonly Control[] = ["take", "release", "arm", "disarm", "hold", "follow", "clear", "drag", "settings", "record"]; // prettier-ignore
const allowed = (now: Situation) => CONTROLS.filter((control) => whyNot(control, now) === null);

test("each state allows just its own ways out", () => {
  expect(allowed(operating)).toEqual(["release", "arm", "settings", "record"]);
  expect(allowed({ ...operating, mode: MODE.HOLD })).toEqual(["release", "disarm", "follow", "drag", "settings", "record"]); // prettier-ignore
  expect(allowed({ ...operating, mode: MODE.E_STOP })).toEqual(["release", "clear", "settings", "record"]);
  expect(allowed({ ...operating, mode: MODE.REST })).toEqual(["release", "hold", "settings", "record"]);
});

test("a viewer may only take a free lease, and everyone may E-STOP", () => {
  const viewer = { ...operating, mine: false, holder: "ivy" };
  expect(allowed(viewer)).toEqual([]);
  expect(whyNot("arm", viewer)).toBe("ivy operates");
  expect(allowed({ ...viewer, held: false })).toEqual(["take"]);
  expect(whyNot("e_stop", { ...viewer, online: false })).toBeNull();
});

test("a viewer's token takes nothing by itself, but may ask; an operator's may take over", () => {
  const free: Situation = { ...operating, mine: false, held: false, holder: "" };
  const held: Situation = { ...free, held: true, holder: "ivy" };
  const looking = "The viewer's token is for looking and for the E-STOP";
  expect([whyNot("take", { ...free, role: "viewer" }), whyNot("arm", { ...free, role: "viewer" })]).toEqual([looking, looking]); // prettier-ignore
  expect([whyNot("edit", { ...free, role: "viewer" }), whyNot("edit", free)]).toEqual([looking, null]);
  expect([whyNot("ask", { ...held, role: "viewer" }), whyNot("ask", free)]).toEqual([
    null,
    "Nobody operates",
  ]);
  expect([whyNot("take_over", held), whyNot("take_over", { ...held, role: "viewer" })]).toEqual([null, looking]); // prettier-ignore
  expect(allowed({ ...operating, role: "viewer" }), "an operator handed it over").toEqual(allowed(operating));
});

test("without a connection or a rig nothing moves", () => {
  expect(allowed({ ...operating, online: false })).toEqual([]);
  expect(allowed({ ...operating, rigLive: false })).toEqual(["release", "settings"]);
  expect(allowed({ ...operating, rigLive: false, recording: true })).toContain("record");
});

test("the on-time share counts the last minute and starts anew with the rig", () => {
  const meter = new OnTime();
  for (let s = 0; s <= 100; s++) meter.add(1000 * s, s <= 20 ? 10 * s : 200, s);
  expect(meter.share()).toBe(1);
  meter.add(0, 0, 101);
  expect(meter.share()).toBeNaN();
  meter.add(1000, 10, 102);
  expect(meter.share()).toBeCloseTo(0.99, 9);
});

test("the trail shows two seconds, oldest first, fading", () => {
  const trail = new Trail();
  for (let i = 0; i < 400; i++) trail.push(i, 0, i / 100);
  const seen: number[] = [];
  trail.visit(3.99, (x, _y, freshness) => {
    seen.push(x);
    expect(freshness).toBeGreaterThan(0);
  });
  expect(seen.at(0)).toBeGreaterThan(180);
  expect(seen.at(-1)).toBe(399);
});

test("a status that repeats itself keeps its object, so that controls do not render", () => {
  const old = { K_P: [1, 2] };
  expect(keep(old, { K_P: [1, 2] })).toBe(old);
  expect(keep(old, { K_P: [1, 3] })).not.toBe(old);
});
