import { expect, test } from "vitest";
import { Ring } from "../../live/ring";
import { Painters } from "../../ui/painters";
import type { ChartPainter } from "./painter";
import { Painting } from "./painting";
import { FOLLOWING, paused } from "./view";

/** `count` charts that always have something new, and who was painted in each frame. */
function charts(count: number) {
  const ring = new Ring(8);
  const none = new Float32Array();
  ring.push({ first: 0, channels: new Uint32Array(), t: Float64Array.of(20), low: none, high: none });
  const painting = new Painting(ring, new Painters(() => undefined));
  const painted: number[] = [];
  const made = Array.from({ length: count }, (_, i) => {
    const follow = () => painted.push(i) > 0;
    const chart = { name: `plot ${i}`, seen: true, follow };
    painting.add(chart as unknown as ChartPainter);
    return chart;
  });
  const frames = (many: number, view = FOLLOWING) =>
    Array.from({ length: many }, () => {
      painted.length = 0;
      painting.step(view, 10, []);
      return painted.toSorted();
    });
  return { made, frames };
}

test("charts that follow the rig are painted in the same frame, and none in the frames between", () => {
  const { frames } = charts(3);
  expect(frames(6)).toEqual([[], [], [0, 1, 2], [], [], [0, 1, 2]]);
  expect(charts(1).frames(2)).toEqual([[0], [0]]);
});

test("of many charts four are painted in a frame, in turns", () => {
  expect(charts(8).frames(8).filter((painted) => painted.length > 0)).toEqual([[1, 2, 3, 4], [0, 5, 6, 7]]); // prettier-ignore
});

test("all charts are painted in one frame when the picture is stopped", () => {
  const { frames } = charts(8);
  expect(frames(1, paused({ newest: 20, seconds: 10 }))).toEqual([[0, 1, 2, 3, 4, 5, 6, 7]]);
});

test("a chart out of sight is not painted, and is again once it is seen", () => {
  const { made, frames } = charts(2);
  made[1].seen = false;
  expect(frames(2)).toEqual([[0], [0]]);
  made[1].seen = true;
  expect(frames(2)).toEqual([[], [0, 1]]);
});
