import { expect, test } from "vitest";
import { EMPTY_PAGE } from "../live/page";
import { MODE } from "../live/modes";
import { primaryOf, type Primary } from "./PrimaryAction";

const mine = { ...EMPTY_PAGE.lease, held: true, mine: true };
const theirs = { ...EMPTY_PAGE.lease, held: true, holder: "Mole" };

test("one action leads on from every state, and no one moves anything without control", () => {
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
    expect(primaryOf({ ...EMPTY_PAGE, lease: mine, mode: MODE[name] })).toBe(wanted);
    expect(primaryOf({ ...EMPTY_PAGE, lease: EMPTY_PAGE.lease, mode: MODE[name] })).toBe("take");
    expect(primaryOf({ ...EMPTY_PAGE, lease: theirs, mode: MODE[name] })).toBe(
      wanted === "clear" ? "clear" : "take",
    );
  }
  expect(primaryOf({ ...EMPTY_PAGE, lease: mine, mode: null })).toBe("arm");
});

test("while the twin is paused its operator continues, and no one else is offered that", () => {
  const health = {
    rig_connected: true,
    rig_age: 0,
    link_rtt: 0,
    viewers: 1,
    trouble: "",
    starting: "",
    on_time: null,
    lost: null,
    energy_balance: null,
    server: "",
    paused: true,
  };
  const paused = { ...EMPTY_PAGE, online: true, rigLive: true, mode: MODE.FOLLOW, health };
  expect(primaryOf({ ...paused, lease: mine })).toBe("time");
  expect(primaryOf({ ...paused, lease: theirs })).toBe("take");
  expect(primaryOf({ ...paused, lease: mine, rigLive: false })).toBe("hold");
});
