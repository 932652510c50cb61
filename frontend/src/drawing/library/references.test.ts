import { expect, test } from "vitest";
import type { ReferenceInfo, ReferencePath } from "../../api/types";
import { EMPTY_PAGE, type Page } from "../../live/page";
import { Store } from "../../ui/store";
import { chosenInfo, References } from "./references";
import { factsOf, menuOf, drawnShape, shapesOf, thumbnailPath } from "./shown";

const info = (name: string, more: Partial<ReferenceInfo> = {}): ReferenceInfo => ({
  ...{ name, task: "Task 1", title: name.toUpperCase(), duration: 25, approach: 2, length: 0.125 },
  ...{ peak_speed: 0.005, frequency: null, K_FF: 0, reachable: true, reason: "" },
  ...more,
});

const path = (name: string): ReferencePath => ({
  name,
  t: [0, 1, 2, 2.5, 3, 3.5],
  points: [[0.25, 0], [0.2, 0.1], [0.1, 0.1], [0.1, 0.2], [0.1, 0.1], [0.1, 0.2]], // prettier-ignore
  start: 2,
});

/** A server whose answers come when the test lets them. */
function harness() {
  const page = new Store<Page>(EMPTY_PAGE);
  const waiting = new Map<string, { give: () => void; refuse: () => void }>();
  const reports: string[] = [];
  const source = {
    references: () => Promise.resolve([info("vu"), info("step")]),
    reference: (name: string) =>
      new Promise<ReferencePath>((resolve, reject) => {
        const refuse = () => {
          reject(new Error("gone"));
        };
        waiting.set(name, { give: () => { resolve(path(name)); }, refuse }); // prettier-ignore
      }),
  };
  const references = new References(page, { report: (title) => reports.push(title) }, source);
  return { page, references, waiting, reports };
}

test("a chosen reference is drawn once its points have come, and cleared again", async () => {
  const { page, references, waiting } = harness();
  await references.learn();
  const done = references.choose("vu");
  expect(page.get()).toMatchObject({ chosen: "vu", reference: null });
  waiting.get("vu")?.give();
  await done;
  expect(page.get().reference).toEqual(path("vu"));
  expect(chosenInfo(page.get())?.title).toBe("VU");
  await references.choose(null);
  expect(page.get()).toMatchObject({ chosen: null, reference: null });
});

test("an answer to an older choice is not drawn", async () => {
  const { page, references, waiting } = harness();
  const [first, second] = [references.choose("vu"), references.choose("step")];
  waiting.get("step")?.give();
  waiting.get("vu")?.give();
  await Promise.all([first, second]);
  expect(page.get().reference?.name).toBe("step");
});

test("a rig that comes back draws the chosen reference again, and the old lines stay until then", async () => {
  const { page, references, waiting } = harness();
  const done = references.choose("vu");
  waiting.get("vu")?.give();
  await done;
  const shown = page.get().reference;
  const learnt = references.learn();
  await Promise.resolve();
  expect(page.get().reference).toBe(shown);
  await new Promise((resolve) => setTimeout(resolve));
  waiting.get("vu")?.give();
  await learnt;
  expect(page.get().reference).toBe(shown);
});

test("a reference that cannot be had is reported and not left chosen", async () => {
  const { page, references, waiting, reports } = harness();
  const done = references.choose("vu");
  waiting.get("vu")?.refuse();
  await done;
  expect(page.get().chosen).toBeNull();
  expect(reports).toEqual(["Reference not shown"]);
});

test("each shape of the library is offered once, and nothing that jumps", () => {
  const info = (name: string, title: string, peak_speed: number | null = 1) =>
    ({ name, title, peak_speed, frequency: null }) as ReferenceInfo;
  const titles = ["Circle, 0.25 Hz", "Circle, 2 Hz", "Sweep (sensing)", "VU"].map((title) =>
    info(title, title),
  );
  expect(shapesOf([info("step", "Four steps", null), ...titles]).map(({ label }) => label)).toEqual(["Circle", "Sweep", "VU"]); // prettier-ignore
});

test("the menu groups references by task and marks what is out of reach", () => {
  const menu = menuOf([info("a"), info("b", { task: "Task 2" }), info("c", { reachable: false })]);
  expect(menu.map(({ group, items }) => [group, items.map(({ label }) => label)])).toEqual([
    ["Task 1", ["A", "C (out of reach)"]],
    ["Task 2", ["B"]],
  ]);
});

test("facts carry units; what jumps has no speed, and what is out of reach no approach", () => {
  expect(factsOf(info("vu"))).toEqual([
    ["Length", "125 mm"],
    ["Duration", "25 s"],
    ["Peak speed", "5.0 mm/s"],
    ["From rest", "2 s"],
  ]);
  const jumps = info("step", { peak_speed: null, reachable: false, frequency: 0.25 });
  expect(factsOf(jumps).slice(2)).toEqual([
    ["Peak speed", "jumps"],
    ["Frequency", "0.25 Hz"],
  ]);
});

test("a shape is drawn without the way there, and only one lap of a periodic one", () => {
  const { points, start } = path("vu");
  expect(drawnShape(path("vu"), null)).toEqual(points.slice(start));
  expect(drawnShape(path("vu"), 1)).toHaveLength(3);
});

test("a thumbnail fills its box with equal scales, y up; a straight line lies in the middle, and nothing is nothing", () => {
  expect(thumbnailPath([[0, 0], [0.02, 0.01]], 40, 30)).toBe("M0.0 25.0L40.0 5.0"); // prettier-ignore
  expect(thumbnailPath([[0.1, 0.1], [0.1, 0.3]], 40, 30)).toBe("M20.0 30.0L20.0 0.0"); // prettier-ignore
  expect(thumbnailPath([], 40, 30)).toBe("");
});
