import { expect, test } from "vitest";
import {
  answered,
  bodyOf,
  INPUTS,
  mostOf,
  foundText,
  lackingText,
  nextStep,
  standingOf,
  usualPoint,
  written,
  type StepView,
} from "./steps";

const step: StepView = {
  name: "drivers",
  title: "Drivers",
  purpose: "",
  state: "todo",
  accepted: false,
  result: "",
  numbers: [],
  writes: [],
  lacks: "drivers not checked",
  withdrawn: "",
  needs: [],
  by: "",
  at: null,
};

test("what a step needs decides whether it is next or has to wait", () => {
  expect(standingOf(step).word).toBe("next");
  expect(standingOf({ ...step, needs: ["Drivers must be accepted first"] }).word).toBe("to do");
  expect(standingOf({ ...step, state: "done" }).word).toBe("to be accepted");
  expect(standingOf({ ...step, state: "done", accepted: true }).word).toBe("accepted");
  expect(standingOf({ ...step, state: "failed", accepted: true }).word).toBe("failed");
});

test("the step under way wants attention, else the first that is not accepted", () => {
  const steps = [
    { ...step, accepted: true },
    { ...step, name: "jog" as const },
  ];
  expect(nextStep({ running: null, steps })).toBe("jog");
  const running = { step: "drivers" as const, doing: "", share: 0, waits: false, by: "" };
  expect(nextStep({ running, steps })).toBe("drivers");
  expect(nextStep({ running: null, steps: [{ ...step, accepted: true }] })).toBeNull();
});

test("a rig says what it lacks until it is commissioned", () => {
  const state = {
    available: true,
    reason: "",
    rig: "lab",
    steps: [],
    running: null,
    jog: null,
    captured: [],
    complete: false,
    missing: ["frame assumed, not measured", "no closed loop tried"],
  };
  expect(lackingText(state)).toBe("Not commissioned: frame assumed, not measured, no closed loop tried");
  expect(lackingText({ ...state, complete: true, missing: [] })).toBe("");
});

test("no more pressure can be typed than the server takes of this actuator", () => {
  const [pressure] = INPUTS.pressure;
  expect([mostOf(pressure, 241e3), mostOf(pressure, 100e3)]).toEqual([120, 50]);
  expect(mostOf(INPUTS.jog[0], 100e3)).toBe(20);
  expect(mostOf(INPUTS.jog[0], 400e3)).toBe(40);
  expect(mostOf(INPUTS.decay[1], 100e3)).toBe(90);
});

test("a step is begun with what was typed, in SI, and the rest as usual", () => {
  expect(bodyOf("jog", { pressure: 20 })).toEqual({ pressure: 20e3, repeats: 3, grid: 5, share: 0.7 });
  expect(bodyOf("jog", { pressure: "25.50" }).pressure).toBe(25.5e3);
  expect(bodyOf("jog", { pressure: "" }).pressure).toBeNull();
  expect(bodyOf("decay", { share: 50, repeats: 2, grid: 9 })).toEqual({
    pressure: null,
    repeats: 2,
    grid: 5,
    share: 0.5,
  });
});

test("numbers carry a unit that fits them, and their interval", () => {
  const number = {
    name: "dead time",
    value: 0.0482,
    unit: "s",
    low: 0.0479,
    high: 0.0486,
    bound: "",
    kept: true,
  };
  expect(foundText(number)).toBe("48.2 ms (47.9 to 48.6)");
  expect(foundText({ ...number, low: null, high: null, value: null })).toBe("–");
  expect(foundText({ ...number, low: null, high: null, value: 71030.67 })).toBe("71031 s");
  expect(foundText({ ...number, low: null, high: null, value: 0.0123, unit: "1" })).toBe("0.0123");
  expect(foundText({ ...number, low: null, high: null, value: 5.47e6, unit: "Pa/s" })).toBe("5470 kPa/s");
});

test("values of the rig file are shown as they are written there", () => {
  expect(written(null)).toBe("not given");
  expect(written([[0.1234567, 1], true])).toBe("[[0.123457, 1], true]");
});

test("a jogged chamber is right only where its own sensor rose", () => {
  const jogged = { commanded: "u1-" as const, rises: [0, 21e3, null, 0], rose: "u1-" as const, filled: null };
  expect(answered(jogged)).toEqual({ text: "its own sensor rose, +21 kPa", good: true });
  expect(answered({ ...jogged, commanded: "u2+" })).toEqual({
    text: "the sensor of u1- rose, +21 kPa",
    good: false,
  });
  expect(answered({ ...jogged, rose: null }).good).toBe(false);
});

test("the tip's label is captured where no one chose a point, or the only one there is", () => {
  expect(usualPoint(["six", "tip"], { six: 6, tip: 10 })).toBe("tip");
  expect(usualPoint(["#1"], {})).toBe("#1");
  expect(usualPoint(["#1", "#2"], {})).toBeNull();
});
