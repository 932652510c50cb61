import { beforeEach, expect, test } from "vitest";
import type { Field, Point } from "../../api/types";
import { Trail } from "../../live/trail";
import { Telemetry } from "../../live/telemetry";
import golden from "../../live/__fixtures__/golden.json";
import { INK } from "../../ui/colours";
import { sheetOf, type Look } from "./canvas";
import type { Figure } from "./figure";
import { FigureLayer } from "./figureLayer";

const layout = golden.layout as Field[];
const LOOK: Look = {
  view: { centre: [0, 0], scale: 1000 },
  size: { width: 800, height: 400 },
  scheme: "dark",
  ratio: 1,
  hidden: new Set(),
};
const PX = 1e-3;

let layer: FigureLayer;
let record: DataView;
let telemetry: Telemetry;
let trail: Trail;
let painted = 0;

beforeEach(() => {
  layer = new FigureLayer();
  painted = 0;
  trail = new Trail();
  telemetry = new Telemetry(layout);
  record = new DataView(new ArrayBuffer(Math.max(...layout.map(({ offset }) => offset)) + 2048));
  telemetry.load(record.buffer as ArrayBuffer, 0);
});

/** A context that draws nowhere. */
const nowhere = new Proxy({}, { get: () => () => undefined, set: () => true }) as CanvasRenderingContext2D;

/** Write `value` [m] into a place of the record, whatever its type. */
function write(name: string, index: number, value: number): void {
  const field = layout.find((one) => one.name === name);
  if (field?.type === "float64") record.setFloat64(field.offset + 8 * index, value, true);
  else if (field?.type === "float32") record.setFloat32(field.offset + 4 * index, value, true);
  else if (field) record.setInt32(field.offset + 8 * index, value, true);
}

/** Offer the figure to the layer at page time `now` [s]; true if it was painted. */
function isPainted(now: number, change: Partial<Figure> = {}, look = LOOK): boolean {
  const before = painted;
  const figure = { telemetry, trail, handle: null, width: 0.03, now, frames: now * 60, ...change };
  layer.paint(look, figure, () => {
    painted += 1;
    return sheetOf(nowhere, look.view, look.size, INK[look.scheme]);
  });
  return painted > before;
}

const handle = (point: Point) => ({ point, acknowledged: true, movable: true });

test("the figure is painted once, and not again while nothing moves", () => {
  expect(isPainted(1)).toBe(true);
  for (let frame = 1; frame < 200; frame++) expect(isPainted(1 + frame / 60)).toBe(false);
});

test.each(["backbone", "twin_backbone", "markers", "p_ref"])(
  "half a pixel of %s is painted at once",
  (name) => {
    isPainted(1);
    write(name, 0, 0.51 * PX);
    expect(isPainted(1.001)).toBe(true);
  },
);

test("half a pixel of the target's handle is painted at once, and so are its states", () => {
  isPainted(1, { handle: handle([0, 0]) });
  expect(isPainted(1.001, { handle: handle([0.51 * PX, 0]) })).toBe(true);
  const hollow = { ...handle([0.51 * PX, 0]), acknowledged: false };
  expect(isPainted(1.002, { handle: hollow })).toBe(true);
  expect(isPainted(1.003, { handle: { ...hollow, movable: false } })).toBe(true);
  expect(isPainted(1.004, { handle: null })).toBe(true);
});

test("half a pixel is a pixel of the device", () => {
  const fine = { ...LOOK, ratio: 2 };
  isPainted(1, {}, fine);
  write("backbone", 0, 0.26 * PX);
  expect(isPainted(1.001, {}, fine)).toBe(true);
});

test("a smaller move is painted a fifth of a second later, less than a tenth of a pixel never", () => {
  isPainted(1);
  write("backbone", 0, 0.2 * PX);
  expect(isPainted(1.1)).toBe(false);
  expect(isPainted(1.21)).toBe(true);
  write("backbone", 0, 0.25 * PX);
  expect(isPainted(9)).toBe(false);
});

test("slow creep is painted: a move counts from what was painted", () => {
  isPainted(1);
  for (let step = 1; step <= 6; step++) {
    write("backbone", 0, 0.09 * step * PX);
    isPainted(1 + step / 1000);
  }
  expect(painted).toBe(2);
});

test("a sensor that drops out and a target out of reach are painted at once", () => {
  isPainted(1);
  write("sensed", 0, 1);
  expect(isPainted(1.001)).toBe(true);
  write("reachable", 0, 1);
  expect(isPainted(1.002)).toBe(true);
  write("markers", 0, NaN);
  expect(isPainted(1.003)).toBe(true);
  expect(isPainted(1.004)).toBe(false);
});

test("a trail is painted every frame until it has faded; the tremble under the tip's disc is none", () => {
  isPainted(1);
  trail.push(0, 0, 1);
  trail.push(1 * PX, 0, 1.01);
  expect(isPainted(1.02)).toBe(false);
  trail.push(9 * PX, 0, 1.03);
  for (let frame = 0; frame < 60; frame++) expect(isPainted(1.04 + frame / 60)).toBe(true);
  expect(isPainted(3.2)).toBe(true);
  expect(isPainted(3.22)).toBe(false);
});

test("another zoom, size, theme or resolution is painted, and so is a canvas that came back empty", () => {
  isPainted(1);
  expect(isPainted(1.001, {}, { ...LOOK, scheme: "light" })).toBe(true);
  expect(isPainted(1.002, {}, { ...LOOK })).toBe(true);
});

test("another width of the actuator is painted at once", () => {
  isPainted(1);
  expect(isPainted(1.001, { width: 0.04 })).toBe(true);
});

test("what could not be painted is tried again", () => {
  layer.paint(LOOK, { telemetry, trail, handle: null, width: 0.03, now: 1, frames: 1 }, () => null);
  expect(isPainted(1.001)).toBe(true);
});
