import { expect, test } from "vitest";
import { MODE } from "../live/modes";
import { whyNot, type Control, type Situation } from "./permission";

const operating: Situation = {
  ...{
    online: true,
    unheard: false,
    rigLive: true,
    starting: "",
    mode: MODE.VENTED,
    mine: true,
    held: true,
    holder: "me",
    clutch: false,
    recording: false,
    role: "operator",
    locked: false,
    macro: false,
    twin: true,
    uncommissioned: false,
    paused: false,
  },
};

const CONTROLS: readonly Control[] = ["take", "release", "arm", "disarm", "hold", "follow", "clear", "drag", "settings", "record"]; // prettier-ignore

const allowed = (now: Situation) => CONTROLS.filter((control) => whyNot(control, now) === null);

test("a connection by which nothing comes is no connection, whatever the rig does", () => {
  const lost = { ...operating, unheard: true, rigLive: false };
  expect(whyNot("arm", lost)).toBe("No connection to the server");
  expect(whyNot("arm", { ...operating, rigLive: false })).toBe("The rig does not answer");
});

test("devices whose frame and signs no one accepted are armed by their commissioning alone", () => {
  const fresh = { ...operating, twin: false, uncommissioned: true };
  expect(whyNot("arm", fresh)).toBe(
    "Not commissioned: accept drivers, chambers, frame and signs first (Rig tab)",
  );
  for (const control of ["disarm", "hold", "e_stop"] as const)
    expect(whyNot(control, { ...fresh, mode: MODE.FOLLOW })).toBeNull();
});

test("each state allows just its own ways out", () => {
  expect(allowed(operating)).toEqual(["release", "arm", "settings", "record"]);
  expect(allowed({ ...operating, mode: MODE.HOLD })).toEqual(["release", "disarm", "follow", "drag", "settings", "record"]); // prettier-ignore
  expect(allowed({ ...operating, mode: MODE.E_STOP })).toEqual(["release", "clear", "settings", "record"]);
  expect(allowed({ ...operating, mode: MODE.REST })).toEqual(["release", "hold", "settings", "record"]);
});

test("only a recording that runs is marked, by who operates, in whatever state the rig is", () => {
  const recording = { ...operating, recording: true, rigLive: false, mode: null };
  expect(whyNot("mark", operating)).toBe("Nothing is recorded now");
  expect(whyNot("mark", recording)).toBeNull();
  expect(whyNot("mark", { ...recording, mine: false, holder: "ivy" })).toBe("ivy operates");
});

test("while a macro runs Hold ends it, in whatever state the rig is", () => {
  for (const mode of [MODE.VENTED, MODE.HOLD, MODE.E_STOP])
    expect(whyNot("hold", { ...operating, mode, macro: true })).toBeNull();
  expect(whyNot("hold", { ...operating, macro: true, mine: false, holder: "ivy" })).toBe("ivy operates");
});

test("while the twin is paused nothing begins, and what stills it and its time stay in reach", () => {
  const paused = { ...operating, mode: MODE.FOLLOW, paused: true };
  expect(allowed(paused)).toEqual(["release", "disarm", "hold", "settings", "record"]);
  expect(whyNot("drag", paused)).toBe("The twin is paused: let it go on first (P)");
  expect(whyNot("time", paused)).toBeNull();
  expect(whyNot("time", { ...paused, mine: false, holder: "ivy" })).toBe("ivy operates");
  expect(whyNot("time", { ...operating, twin: false })).toMatch(/^Only a twin's time/);
});

test("of a page that is locked only the stops act", () => {
  const locked: Situation = { ...operating, mode: MODE.FOLLOW, locked: true };
  expect(allowed(locked)).toEqual(["hold"]);
  expect(whyNot("e_stop", locked)).toBeNull();
  expect(whyNot("drag", locked)).toBe("The page is locked: unlock it first");
  expect([allowed({ ...locked, mine: false, held: false }), allowed({ ...locked, mine: false })]).toEqual([
    [],
    [],
  ]);
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
    "No one operates",
  ]);
  expect([whyNot("take_over", held), whyNot("take_over", { ...held, role: "viewer" })]).toEqual([null, looking]); // prettier-ignore
  expect(allowed({ ...operating, role: "viewer" }), "an operator handed it over").toEqual(allowed(operating));
});

test("with the held clutch on, Follow alone does nothing", () => {
  const clutched = { ...operating, mode: MODE.HOLD, clutch: true };
  expect(whyNot("follow", clutched)).toContain("Held clutch is on");
  expect(whyNot("drag", clutched)).toBeNull();
});

test("a rig that was told to start again is not called silent", () => {
  const starting = { ...operating, rigLive: false, starting: "P2" };
  expect(whyNot("arm", starting)).toBe("The rig starts with actuator P2");
  expect(whyNot("e_stop", starting)).toBeNull();
  expect(whyNot("arm", { ...starting, starting: "" })).toBe("The rig does not answer");
});

test("without a connection or a rig nothing moves", () => {
  expect(allowed({ ...operating, online: false })).toEqual([]);
  expect(allowed({ ...operating, rigLive: false })).toEqual(["release", "settings"]);
  expect(allowed({ ...operating, rigLive: false, recording: true })).toContain("record");
});
