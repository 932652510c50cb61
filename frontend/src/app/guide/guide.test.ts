import { expect, test } from "vitest";
import { cardPlace, clearOf } from "./Guide";

const box = (left: number, top: number, width: number, height: number) => ({ left, top, width, height });
const card = box(0, 0, 300, 150);

test("it covers nothing that is said of the rig", () => {
  const card = { left: 80, top: 100, width: 300, height: 150 };
  const red = { left: 12, top: 130, width: 200, height: 70 };
  expect(clearOf([red], card)).toBe(212);
  expect(clearOf([{ ...red, left: 400 }], card)).toBe(100);
  expect(clearOf([], card)).toBe(100);
});

test("the guide's card stands below a control, above it at the bottom, and within a large one", () => {
  expect(cardPlace(box(100, 20, 80, 30), card, 1280, 720)).toEqual({ left: 100, top: 62 });
  expect(cardPlace(box(100, 650, 80, 30), card, 1280, 720)).toEqual({ left: 100, top: 488 });
  const { left, top } = cardPlace(box(0, 80, 740, 460), card, 1280, 720);
  expect([left > 0, top + card.height < 540]).toEqual([true, true]);
});

test("the card never leaves the window, and leaves its upper edge to the E-STOP", () => {
  expect(cardPlace(box(1200, 20, 80, 30), card, 1280, 720).left).toBe(972);
  expect(cardPlace(box(5, 5, 10, 10), card, 290, 120)).toEqual({ left: 8, top: 60 });
});
