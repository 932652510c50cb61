import { expect, test } from "vitest";
import { decodeBinary, LayoutError } from "../api/socket";
import type { Field } from "../api/types";
import { MODE } from "./modes";
import { errorOf, RecordReader, Telemetry } from "./telemetry";
import golden from "./__fixtures__/golden.json";

const layout = golden.layout as Field[];
const values = golden.values as Record<string, (number | null)[]>;

function bytesOf(base64: string): ArrayBuffer {
  return Uint8Array.from(atob(base64), (character) => character.charCodeAt(0)).buffer;
}

test("every field of a frame written by the server's encoder reads as numpy wrote it", () => {
  const buffer = bytesOf(golden.frame);
  const message = decodeBinary(buffer);
  if (message.kind !== "frame") throw new Error("not a frame");
  const record = new RecordReader(layout);
  record.load(buffer, message.offset);
  for (const [name, expected] of Object.entries(values)) {
    const field = record.field(name);
    expect(field.length, name).toBe(expected.length);
    expect(
      Array.from(expected, (_, i) => field.at(i)),
      name,
    ).toEqual(expected.map((value) => value ?? NaN));
  }
});

test("plot bins written by the server's encoder come out as times, lows and highs", () => {
  const message = decodeBinary(bytesOf(golden.plot));
  if (message.kind !== "plot") throw new Error("not plot bins");
  expect([message.bins.first, ...message.bins.channels]).toEqual([7, 0, 3, 5]);
  expect([...message.bins.t]).toEqual([1, 1.016]);
  expect([...message.bins.low]).toEqual([1, 2, NaN, 4, 5, 6]);
  expect([...message.bins.high]).toEqual([7, 8, NaN, 10, 11, 12]);
});

test("a point with a coordinate that is not finite is no point", () => {
  const telemetry = new Telemetry(layout);
  telemetry.load(bytesOf(golden.frame), 8);
  expect(telemetry.point("p_meas")).toBeNull();
  expect(telemetry.point("markers", 9)).not.toBeNull();
});

test("before the first record every field reads as nan", () => {
  expect(new Telemetry(layout).at("tick")).toBeNaN();
});

test("a record that is cut short, a plot that does not fit and an unknown kind are refused", () => {
  const frame = bytesOf(golden.frame);
  expect(() => {
    new RecordReader(layout).load(frame.slice(0, -1), 8);
  }).toThrow(LayoutError);
  expect(() => decodeBinary(bytesOf(golden.plot).slice(0, -4))).toThrow(LayoutError);
  expect(() => decodeBinary(new Uint32Array([2, 0]).buffer)).toThrow(LayoutError);
  expect(() => decodeBinary(new Uint32Array([9, 0]).buffer)).toThrow("unknown kind 9");
  expect(() => decodeBinary(new ArrayBuffer(3))).toThrow(LayoutError);
});

test("a layout without a field that the page needs is refused by that field's name", () => {
  expect(() => new Telemetry(layout.filter((field) => field.name !== "p_ref"))).toThrow('"p_ref"');
});

test("the error is of the tip that the loop takes, and of none where nothing is followed", () => {
  const row = (sensed: number) => ({ at: () => sensed, points: () => 10 });
  expect(errorOf(row(0b1000000000), MODE.FOLLOW)).toBe("measured");
  expect(errorOf(row(0b0000100000), MODE.HOLD)).toBe("estimated");
  expect(
    [MODE.VENTED, MODE.REST, MODE.FAULT, MODE.E_STOP, null].map((mode) => errorOf(row(1023), mode)),
  ).toEqual(Array(5).fill("none"));
});
