import { expect, test } from "vitest";
import { driverFacts, lossOf, namesOf, raw, trouble, troubleGrade, type DriverStatus } from "./drivers";

const camera: DriverStatus = {
  role: "motion_capture",
  driver: "natnet",
  device: "NatNet 4.1 at 127.0.0.1:1510, unicast",
  state: "running",
  detail: "",
  capabilities: ["two-way clock"],
  rate: 99.6,
  age: 0.0053,
  latency: 0.006,
  clock: "two-way",
  clock_offset: 12.25,
  frames: 990,
  lost: 10,
  rejected: 0,
  late: 0,
  reconnects: 1,
  values: {},
};

test("a driver that runs has no trouble, until its newest frame is old", () => {
  expect(trouble(camera)).toBe("");
  expect(trouble({ ...camera, age: 0.4 })).toBe("The newest frame is 400 ms old.");
});

test("what the driver says of its trouble goes before what its state means", () => {
  expect(trouble({ ...camera, state: "lost" })).toMatch(/does not answer/);
  expect(trouble({ ...camera, state: "lost", detail: "the connection was refused" })).toBe(
    "The connection was refused.",
  );
});

test("late answers of a running driver are a warning with their count", () => {
  const late = { ...camera, detail: "answers come after 15 ms, timeout is 10 ms", late: 1234 };
  expect(trouble(late)).toBe("Answers come after 15 ms, timeout is 10 ms.");
  expect([troubleGrade(late), troubleGrade(camera)]).toEqual(["warning", "good"]);
  expect(new Map(driverFacts(late)).get("Late answers")).toBe("1234");
});

test("loss is a share of all frames that were sent, and not a number before the first", () => {
  expect(lossOf(camera)).toBeCloseTo(0.01, 12);
  expect(lossOf({ frames: 0, lost: 0 })).toBeNaN();
});

test("a latency or an age that is not known is never a number", () => {
  const facts = new Map(driverFacts({ ...camera, latency: -1, age: -1, clock: "arrival" }));
  expect(facts.get("Latency")).toBe("not known");
  expect(facts.get("Age")).toBe("–");
  expect(facts.get("Offset")).toBe("–");
  expect(facts.get("Lost")).toBe("10 of 1000 (1.00 %)");
});

test("raw values keep their size, and names are in the order of their numbers", () => {
  expect([raw(0.25281), raw(-12.3456), raw(101325.4), raw(null)]).toEqual([
    "0.2528",
    "-12.35",
    "101325",
    "–",
  ]);
  expect(namesOf({ "#10": [], "#2": [], tip: [] })).toEqual(["#2", "#10", "tip"]);
});
