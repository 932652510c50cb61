import { expect, test } from "vitest";
import { KeyMap } from "../target/keys";
import { pressEscape, type EscapePort, type Layer } from "./escape";

const MODIFIERS = { shiftKey: false, ctrlKey: false, altKey: false, metaKey: false };
const ESCAPE = { key: "Escape", repeat: false, ...MODIFIERS };

/** A layer, and what an Esc does to it where the focus is in it (`own`), or elsewhere and it is told (`told`). */
class FakeLayer implements Layer {
  private open = true;

  constructor(private readonly closes: { readonly own: boolean; readonly told: boolean }) {}

  isOpen(): boolean {
    return this.open;
  }

  key(): void {
    if (this.closes.own) this.open = false;
  }

  hear(): void {
    if (this.closes.told) this.open = false;
  }
}

/** A page on which Esc is pressed: what lies open hears the key after the page's own listener, as in a browser. */
class FakePage implements EscapePort {
  open: FakeLayer[] = [];
  readonly done: string[] = [];
  private readonly keys = new KeyMap();
  private due: (() => void)[] = [];

  layers(): readonly Layer[] {
    return this.open;
  }

  later(action: () => void): void {
    this.due.push(action);
  }

  press(now: number): void {
    pressEscape(this, () => this.done.push(this.keys.press(ESCAPE, "widget", now)?.kind ?? ""));
    this.open.at(-1)?.key();
    while (this.due.length > 0) this.due.shift()?.();
    this.open = this.open.filter((layer) => layer.isOpen());
  }
}

const KINDS: readonly (readonly [string, { readonly own: boolean; readonly told: boolean }])[] = [
  ["a dialog, which listens at the window", { own: true, told: true }],
  ["a menu with the focus in it", { own: true, told: true }],
  ["a popover whose focus stayed on its button", { own: false, told: true }],
  ["a list to choose from", { own: true, told: false }],
  ["a line that is being drawn", { own: true, told: false }],
];

test.each(KINDS)("the Esc that closes %s is no stop, and is none of the two", (_, closes) => {
  const page = new FakePage();
  page.open = [new FakeLayer(closes)];
  page.press(0);
  expect([page.done, page.open]).toEqual([[], []]);
  page.press(100);
  expect(page.done).toEqual(["hold"]);
  page.press(900);
  expect(page.done).toEqual(["hold", "e_stop"]);
});

test("two layers take two Esc, one each", () => {
  const page = new FakePage();
  page.open = [KINDS[0][1], KINDS[3][1]].map((closes) => new FakeLayer(closes));
  page.press(0);
  expect([page.done, page.open.length]).toEqual([[], 1]);
  page.press(100);
  expect([page.done, page.open.length]).toEqual([[], 0]);
});

test("a browser that is about to leave fullscreen has closed something, though it is done later", () => {
  const page = new FakePage();
  const fullscreen = new FakeLayer({ own: false, told: false });
  fullscreen.isOpen = () => false;
  page.open = [fullscreen];
  page.press(0);
  expect(page.done).toEqual([]);
});

test("what no Esc closes takes no stop away", () => {
  const page = new FakePage();
  page.open = [new FakeLayer({ own: false, told: false })];
  page.press(0);
  page.press(900);
  expect(page.done).toEqual(["hold", "e_stop"]);
});

test("two Esc on the bare page stop at once, with nothing to wait for", () => {
  const page = new FakePage();
  page.later = () => expect.unreachable("nothing is open");
  page.press(0);
  page.press(900);
  expect(page.done).toEqual(["hold", "e_stop"]);
});

test("a closed layer between two Esc of the bare page takes nothing from them", () => {
  const page = new FakePage();
  page.press(0);
  page.open = [new FakeLayer(KINDS[0][1])];
  page.press(300);
  page.press(600);
  expect(page.done).toEqual(["hold", "e_stop"]);
});
