import { expect, test } from "vitest";
import { EMPTY_PAGE } from "../live/page";
import { MODE } from "../rig/modes";
import { primaryOf, type Primary } from "./PrimaryAction";

const mine = { ...EMPTY_PAGE.lease, held: true, mine: true };
const theirs = { ...EMPTY_PAGE.lease, held: true, holder: "Mole" };

test("one action leads on from every state, and nobody moves anything without control", () => {
  const expected: [keyof typeof MODE, Primary][] = [
    ["VENTED", "arm"],
    ["HOLD", "follow"],
    ["FOLLOW", "hold"],
    ["TRACK", "hold"],
    ["REST", "arm"],
    ["FAULT", "clear"],
    ["E_STOP", "clear"],
  ];
  for (const [name, wanted] of expected) {
    expect(primaryOf({ lease: mine, mode: MODE[name] })).toBe(wanted);
    expect(primaryOf({ lease: EMPTY_PAGE.lease, mode: MODE[name] })).toBe("take");
    expect(primaryOf({ lease: theirs, mode: MODE[name] })).toBe(wanted === "clear" ? "clear" : "take");
  }
  expect(primaryOf({ lease: mine, mode: null })).toBe("arm");
});
