import { expect, test } from "vitest";
import { MODE, whyText } from "./modes";

test("an E-STOP that was pressed names who did it", () => {
  const pressed = { mode: MODE.E_STOP, cause: 1, stoppedBy: "ann (viewer)" } as const;
  expect(whyText(pressed)).toBe("by ann (viewer)");
  expect(whyText({ ...pressed, stoppedBy: "" })).toBe("asked for by someone");
});

test("no other state or cause is laid to someone's charge", () => {
  expect(whyText({ mode: MODE.E_STOP, cause: 9, stoppedBy: "ann" })).toBe("pressure out of range");
  expect(whyText({ mode: MODE.HOLD, cause: 1, stoppedBy: "ann" })).toBe("asked for by someone");
  expect(whyText({ mode: MODE.VENTED, cause: 0, stoppedBy: "" })).toBe("");
});
