import { expect, test } from "vitest";
import { MODE, whyText } from "./modes";

test("an E-STOP that was pressed names who did it", () => {
  const pressed = { mode: MODE.E_STOP, cause: 1, stoppedBy: "ann (viewer)", missed: "" } as const;
  expect(whyText(pressed)).toBe("by ann (viewer)");
  expect(whyText({ ...pressed, stoppedBy: "" })).toBe("asked for by someone");
});

test("a sign that was missed is said with whose it was, as soon as the server knows", () => {
  const held = { mode: MODE.HOLD, cause: 3, stoppedBy: "", missed: "the page of ann is closed" } as const;
  expect(whyText(held)).toBe("the page of ann is closed");
  expect(whyText({ ...held, missed: "" })).toBe("no sign from the operator's page");
  expect(whyText({ ...held, cause: 4 })).toBe("no server");
});

test("no other state or cause is laid to someone's charge", () => {
  expect(whyText({ mode: MODE.E_STOP, cause: 9, stoppedBy: "ann", missed: "" })).toBe(
    "pressure out of range",
  );
  expect(whyText({ mode: MODE.HOLD, cause: 1, stoppedBy: "ann", missed: "" })).toBe("asked for by someone");
  expect(whyText({ mode: MODE.VENTED, cause: 0, stoppedBy: "", missed: "" })).toBe("");
});
