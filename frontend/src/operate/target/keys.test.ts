import { expect, test } from "vitest";
import { KeyMap, type Press } from "./keys";

const press = (key: string, more: Partial<Press> = {}): Press => ({
  ...{ key, shiftKey: false, ctrlKey: false, altKey: false, metaKey: false, repeat: false },
  ...more,
});

test("Esc holds, and twice within a second it is an E-STOP, even in a text field", () => {
  const keys = new KeyMap();
  expect(keys.press(press("Escape"), "text", 0)).toEqual({ kind: "hold" });
  expect(keys.press(press("Escape"), "text", 900)).toEqual({ kind: "e_stop" });
  expect(keys.press(press("Escape"), "page", 1000)).toEqual({ kind: "hold" });
  expect(keys.press(press("Escape"), "page", 2100)).toEqual({ kind: "hold" });
});

test("a held Esc key is one press", () => {
  const keys = new KeyMap();
  keys.press(press("Escape"), "page", 0);
  expect(keys.press(press("Escape", { repeat: true }), "page", 40)).toBeNull();
});

test("arrows move the target by 1, 10 or 0.1 mm, only while no control wants them; a repeat is not a fresh press", () => {
  const keys = new KeyMap();
  expect(keys.press(press("ArrowUp"), "page", 0)).toMatchObject({
    kind: "nudge",
    dx: 0,
    dy: 1e-3,
    fresh: true,
  });
  expect(keys.press(press("ArrowLeft", { shiftKey: true }), "page", 0)).toMatchObject({ dx: -1e-2 });
  expect(keys.press(press("ArrowLeft", { ctrlKey: true }), "page", 0)).toMatchObject({ dx: -1e-4 });
  expect(keys.press(press("ArrowUp", { repeat: true }), "page", 0)).toMatchObject({ fresh: false });
  expect(keys.press(press("ArrowUp"), "widget", 0)).toBeNull();
});

test("letters are keys of the page unless they are being typed or belong to the browser", () => {
  const keys = new KeyMap();
  expect(keys.press(press("f"), "widget", 0)).toEqual({ kind: "follow" });
  expect(keys.press(press("f"), "text", 0)).toBeNull();
  expect(keys.press(press("b"), "page", 0)).toEqual({ kind: "mark" });
  expect(keys.press(press("b"), "text", 0)).toBeNull();
  expect(keys.press(press("r", { ctrlKey: true }), "page", 0)).toBeNull();
  expect(keys.press(press("?", { shiftKey: true }), "page", 0)).toEqual({ kind: "help" });
  expect(keys.press(press("2"), "widget", 0)).toEqual({ kind: "panel", place: 2 });
  expect(keys.press(press("2"), "text", 0)).toBeNull();
  expect(keys.press(press("1", { ctrlKey: true }), "page", 0)).toBeNull();
});

test("the last arrow that comes up lets go, and so does a window that loses the keys", () => {
  const keys = new KeyMap();
  keys.press(press("ArrowUp"), "page", 0);
  keys.press(press("ArrowLeft"), "page", 0);
  expect(keys.lift("ArrowUp")).toBeNull();
  expect(keys.lift("ArrowLeft")).toEqual({ kind: "release" });
  expect(keys.lift("ArrowLeft")).toBeNull();
  keys.press(press("ArrowUp"), "page", 0);
  expect(keys.liftAll()).toEqual({ kind: "release" });
  expect(keys.liftAll()).toBeNull();
});
