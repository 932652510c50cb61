import { expect, test } from "vitest";
import type { Point } from "../api/types";
import type { PageStorage } from "../ui/storage";
import { bodyOf, Drawing, sketchOf } from "./drawing";
import { CHARACTERS_MAX, keepDrawing, KEY, parseKept } from "./kept";
import { pieceOf } from "./piece";

const line: Point[] = [[0.1, 0.1], [0.12, 0.1], [0.12, 0.12]]; // prettier-ignore

/** A browser's storage; `room` in characters. */
function shelfOf(texts: Map<string, string>, room = Infinity): PageStorage {
  return {
    getItem: (key) => texts.get(key) ?? null,
    removeItem: (key) => texts.delete(key),
    setItem: (key, text) => {
      if (text.length > room) throw new Error("quota exceeded");
      texts.set(key, text);
    },
  };
}

/** A page that is loaded in a browser with this storage. */
function visit(storage: PageStorage, lost: (why: string) => void = () => undefined): Drawing {
  const drawing = new Drawing();
  keepDrawing(drawing, storage, lost);
  return drawing;
}

test("a drawing survives the page with place, name, manner and selection, but without undo", () => {
  const texts = new Map<string, string>();
  const first = visit(shelfOf(texts));
  first.add([pieceOf(line), pieceOf(line, [0, 1, 2.5])]);
  first.select([1]);
  first.change({ about: [0, 0], shift: [0.2, 0], angle: 0.3, scale: 2 });
  first.settle();
  first.select([0]);
  first.rename("Hook");
  first.follow({ timing: { kind: "duration", duration: 3 }, smoothing: 1e-3, outside: "refuse" });
  const second = visit(shelfOf(texts)).store.get();
  expect(bodyOf(second)).toEqual(bodyOf(first.store.get()));
  expect(sketchOf(second)).toEqual(sketchOf(first.store.get()));
  expect(second.history.past).toEqual([]);
  first.clear();
  expect(sketchOf(visit(shelfOf(texts)).store.get()).pieces).toEqual([]);
});

test("a gesture under way is not kept, and what does not change is not written again", () => {
  const texts = new Map<string, string>();
  const drawing = visit(shelfOf(texts));
  drawing.add([pieceOf(line)]);
  const kept = texts.get(KEY);
  texts.clear();
  drawing.change({ about: [0, 0], shift: [1, 1], angle: 0, scale: 1 });
  drawing.choose("freehand");
  expect(texts.size).toBe(0);
  drawing.abandon();
  drawing.rename("a");
  expect(JSON.parse(texts.get(KEY) ?? "")).toEqual({ ...(JSON.parse(kept ?? "") as object), name: "a" });
});

test("what is too long, or finds no room, is not kept, nor is the older drawing brought back", () => {
  for (const [room, points] of [
    [1000, 100],
    [Infinity, CHARACTERS_MAX / 20],
  ] as const) {
    // prettier-ignore
    const texts = new Map<string, string>();
    const drawing = visit(shelfOf(texts, room));
    drawing.add([pieceOf(line)]);
    expect(texts.size).toBe(1);
    drawing.add([{ ...pieceOf(line), shape: Array.from({ length: points }, (_, i) => [i / 7, i / 3]) }]);
    expect(texts.size).toBe(0);
  }
});

test("the page hears once that a drawing is too long to be kept, and again for the next one", () => {
  const said: string[] = [];
  const drawing = visit(shelfOf(new Map()), (why) => said.push(why));
  const long: Point[] = Array.from({ length: CHARACTERS_MAX / 20 }, (_, i) => [i / 7, i / 3]);
  drawing.add([pieceOf(line)]);
  expect(said).toEqual([]);
  drawing.add([{ ...pieceOf(line), shape: long }]);
  drawing.rename("still too long");
  expect(said).toHaveLength(1);
  expect(said[0]).toContain(`more than the ${CHARACTERS_MAX}`);
  drawing.clear();
  drawing.add([{ ...pieceOf(line), shape: long }]);
  expect(said).toHaveLength(2);
});

test("only a whole drawing is read back", () => {
  const texts = new Map<string, string>();
  visit(shelfOf(texts)).add([pieceOf(line, [0, 1, 2])]);
  const text = texts.get(KEY) ?? "";
  expect(parseKept(text)).not.toBeNull();
  const wrong: [string, string][] = [
    [text, ""],
    [text, "null"],
    [text, "[]"],
    [text, text.slice(0, -1)],
    ['"times":[0,1,2]', '"times":[0,1]'],
    ['"times":[0,1,2]', '"times":[0,1,null]'],
    ['"scale":1', '"scale":0'],
    ['"selected":[0]', '"selected":[1]'],
    ['"selected":[0]', '"selected":[0.5]'],
    ['"group":null', '"group":"a"'],
    ['"kind":"speed"', '"kind":"slow"'],
    ['"speed":0.02', '"speed":"fast"'],
    ['"outside":"project"', '"outside":"ignore"'],
    ['"name":""', '"name":1'],
  ];
  for (const [part, other] of wrong) {
    expect(text).toContain(part);
    expect(parseKept(text.replace(part, other)), other).toBeNull();
  }
});

test("what a page kept that knew one selected piece and no groups is brought back", () => {
  const texts = new Map<string, string>();
  const drawing = visit(shelfOf(texts));
  drawing.add([pieceOf(line)]);
  const text = (texts.get(KEY) ?? "").replace(',"group":null', "");
  for (const [old, now] of [["0", [0]], ["null", []]] as const) {
    const before = text.replace('"selected":[0]', `"selected":${old}`);
    expect(before).not.toContain("group");
    expect(parseKept(before)?.sketch).toEqual({ ...sketchOf(drawing.store.get()), selected: now });
  }
}); // prettier-ignore

test("a browser that keeps nothing leaves the page as it was", () => {
  const fail = () => {
    throw new Error("denied");
  };
  const drawing = visit({ getItem: fail, setItem: fail, removeItem: fail });
  drawing.add([pieceOf(line)]);
  expect(sketchOf(drawing.store.get()).pieces).toHaveLength(1);
});
