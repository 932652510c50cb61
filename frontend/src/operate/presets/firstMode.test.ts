import { expect, test } from "vitest";
import type { FirstModeState } from "../../api/types";
import { kappaToOffer, modeFacts, numberText, progressText, type PlantNumber } from "./firstMode";

const ASSUMED: PlantNumber = { value: 0.352, source: "assumed", low: null, high: null, measured: null, note: "fit to the paper" }; // prettier-ignore
const MEASURED: PlantNumber = { value: 0.331, source: "measured", low: 0.302, high: 0.36, measured: "2026-11-26T12:00:00Z", note: "" }; // prettier-ignore
const RUNNING: FirstModeState = { by: "ivy", state: "running", doing: "step 2 of 6", step: 2, steps: 6, reason: "" }; // prettier-ignore

test("a number says whether it was measured, when and how well, or that it is assumed", () => {
  expect(numberText(ASSUMED, 2)).toBe("0.35, assumed (fit to the paper)");
  expect(numberText({ ...ASSUMED, value: 0.19, source: "file", note: "b and alpha" }, 2)).toBe(
    "0.19, from the actuator's file (b and alpha)",
  );
  expect(numberText({ ...ASSUMED, source: "given", note: "" }, 2)).toBe("0.35, given");
  expect(numberText({ ...ASSUMED, source: "given", note: "[twin] of the rig file" }, 2)).toBe(
    "0.35, given ([twin] of the rig file)",
  );
  expect(numberText(MEASURED, 2)).toMatch(/^0\.33 \(0\.30 to 0\.36\), measured .*2026/);
});

test("frequency, friction and what is not explained are told of a measurement alone", () => {
  const known = { actuator: "P1", zeta: ASSUMED, kappa: ASSUMED, mode: null, observer_kappa: 1 };
  expect(modeFacts(known).map(([name]) => name)).toEqual([
    "Damping ratio",
    "Stiffness factor κ",
    "Observer's κ",
  ]);
  const three = { value: 3.1, low: 3, high: 3.2 };
  const mode = { frequency: three, zeta: three, kappa: three, friction: 1.5e-3, delay: 0.01, misfit: 0.012, pressures: true, travel: 0.1, repeats: 3 }; // prettier-ignore
  expect(modeFacts({ ...known, mode })[3]).toEqual([
    "First mode",
    "3.10 Hz, dry friction ±1.5 mm, 1.2 % not explained",
  ]);
});

test("the measured factor is offered to the observer, and once it has that, its table's", () => {
  const three = { value: 3.1, low: 3, high: 3.2 };
  const mode = { frequency: three, zeta: three, kappa: { value: 40, low: 38, high: 42 }, friction: 0, delay: 0, misfit: 0, pressures: true, travel: 0.1, repeats: 3 }; // prettier-ignore
  const known = { actuator: "P1", zeta: ASSUMED, kappa: ASSUMED };
  expect(kappaToOffer({ ...known, mode: null, observer_kappa: 1 })).toBeNull();
  expect(kappaToOffer({ ...known, mode, observer_kappa: 1 })).toBe(40);
  expect(kappaToOffer({ ...known, mode, observer_kappa: 15 })).toBe(40);
  expect(kappaToOffer({ ...known, mode, observer_kappa: 36 })).toBe(1);
  expect(kappaToOffer({ ...known, mode: null, observer_kappa: 36 })).toBe(1);
  expect(modeFacts({ ...known, mode, observer_kappa: 36 })[2]).toEqual(["Observer's κ", "36.0"]);
});

test("who looks is told how it goes and why it ended, and nothing once it is done", () => {
  expect(progressText(null)).toBe("");
  expect(progressText(RUNNING)).toBe("Measuring: step 2 of 6");
  expect(progressText({ ...RUNNING, state: "ended", reason: "E-STOP" })).toBe("Not measured: E-STOP");
  expect(progressText({ ...RUNNING, state: "done" })).toBe("");
});
