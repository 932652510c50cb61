import { expect, test } from "vitest";
import { lineOf, problemOf } from "./problem";

const TEXT = `name = "rig"
[motion_capture]
driver = "natnet"
options = { server = "127.0.0.1" }
[valves]
driver = "modbus"
pressure_max = 5e9
[valves.loop]
inflate_gain = -3
`;

test("a refusal is taken apart into field, value, bound and line", () => {
  const said = "rig.toml: valves.pressure_max = 5000000000.0: Input should be less than or equal to 1000000";
  expect(problemOf(said, TEXT)).toEqual({
    field: "valves.pressure_max",
    value: "5000000000.0",
    bound: "must be less than or equal to 1000000",
    line: 7,
  });
});

test("what a table as a whole must keep names the field in it", () => {
  const said = "rig.toml: valves: chambers = [0, 1, 1, 2] names a channel twice";
  expect(problemOf(said, TEXT)).toEqual({
    field: "valves.chambers",
    value: "[0, 1, 1, 2]",
    bound: "names a channel twice",
    line: 5,
  });
});

test("what is no TOML is marked where it says so", () => {
  expect(problemOf("rig.toml is not TOML: Invalid value (at line 4, column 9)", TEXT).line).toBe(4);
  expect(problemOf("rig.toml is not TOML: Invalid value (at end of document)", TEXT).line).toBe(9);
});

test("a sentence without a field is shown whole", () => {
  const said = "the rig is in HOLD: it must be vented";
  expect(problemOf(said, TEXT)).toEqual({ field: "", value: "", bound: said, line: null });
});

test("a field is found in its table, else at its nearest table, and never in another table", () => {
  expect(lineOf("valves.driver", TEXT)).toBe(6);
  expect(lineOf("valves.loop.inflate_gain", TEXT)).toBe(9);
  expect(lineOf("motion_capture.options.server", TEXT)).toBe(4);
  expect(lineOf("limits.error_max", TEXT)).toBeNull();
});
