import { expect, test } from "vitest";
import { Layers } from "./layers";

function storage(kept: string | null) {
  const texts = new Map(kept === null ? [] : [["tendril-plan-hidden", kept]]);
  return {
    texts,
    getItem: (key: string) => texts.get(key) ?? null,
    setItem: (key: string, text: string) => void texts.set(key, text),
  };
}

test("a layer that is switched off is off on the next visit, and comes back", () => {
  const browser = storage(null);
  const layers = new Layers(browser);
  layers.toggle("twin");
  layers.toggle("reach");
  layers.toggle("twin");
  expect([...layers.store.get().hidden]).toEqual(["reach"]);
  expect([...new Layers(browser).store.get().hidden]).toEqual(["reach"]);
});

test("what another version has kept, or a browser that keeps nothing, hides nothing else", () => {
  expect([...new Layers(storage("target twin nonsense")).store.get().hidden]).toEqual(["twin"]);
  const closed = () => {
    throw new Error("no storage");
  };
  const layers = new Layers({ getItem: closed, setItem: closed });
  layers.toggle("path");
  expect([...layers.store.get().hidden]).toEqual(["path"]);
});
