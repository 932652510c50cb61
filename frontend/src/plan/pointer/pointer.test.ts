import { beforeAll, expect, test, vi } from "vitest";
import type { Point } from "../../api/types";
import { Seeded } from "../../ui/seeded";
import { fit, toPixel, zoomAbout, type Size, type View } from "../transform";
import type { Gesture } from "./pens";
import type { PlanPointer, PlanSurface } from "./pointer";

interface Around {
  devicePixelRatio: number;
  innerWidth: number;
  innerHeight: number;
  screenX: number;
  screenY: number;
  visualViewport: { scale: number; offsetLeft: number; offsetTop: number };
}

const around: Around = {
  devicePixelRatio: 1,
  innerWidth: 1280,
  innerHeight: 720,
  screenX: 0,
  screenY: 0,
  visualViewport: { scale: 1, offsetLeft: 0, offsetTop: 0 },
};
let Pointer: typeof PlanPointer;
beforeAll(async () => {
  vi.stubGlobal("window", around);
  vi.stubGlobal("WheelEvent", { DOM_DELTA_LINE: 1 });
  Pointer = (await import("./pointer")).PlanPointer;
});

/** The plan's canvas as far as the pointer needs it: a place in the window, and events. */
class Canvas extends EventTarget {
  rect = { left: 0, top: 80, width: 740, height: 460 };
  pointerType = "mouse";
  getBoundingClientRect = () => this.rect;
  setPointerCapture = () => undefined;

  /** A pointer event at `client`, of a pointer that is at `screen` on the screen. */
  say(type: string, client: Point, id = 1, screen = client): void {
    const event = Object.assign(new Event(type, { cancelable: true }), {
      pointerId: id,
      pointerType: this.pointerType,
      button: 0,
      clientX: client[0],
      clientY: client[1],
      screenX: screen[0],
      screenY: screen[1],
      deltaY: 0,
      deltaMode: 0,
      ctrlKey: false,
      getCoalescedEvents: () => [],
    });
    if (type === "wheel") event.deltaY = -120;
    this.dispatchEvent(event);
  }
}

/** Plan and hand: what the pointer does to target and drawing. */
class Plan implements PlanSurface {
  view: View;
  target: Point = [0.2, 0.05];
  readonly moved: { point: Point; fresh: boolean }[] = [];
  readonly drawn: Point[] = [];
  aborted = 0;
  released = 0;
  ended = 0;
  pen = false;
  refuses = false;

  constructor(readonly canvas: Canvas) {
    this.view = fit({ left: -0.15, right: 0.27, bottom: -0.25, top: 0.25 }, canvas.rect, 26);
  }

  get size(): Size {
    return this.canvas.rect;
  }
  handle = () => ({ point: this.target, acknowledged: true, movable: true });
  handleReach = () => 15;
  move(point: Point, fresh: boolean): boolean {
    if (this.refuses) return false;
    this.moved.push({ point, fresh });
    this.target = point;
    return true;
  }
  release(): void {
    this.released += 1;
  }
  abort(): void {
    this.aborted += 1;
  }
  drawing = () => this.pen;
  grab(point: Point): Gesture | null {
    if (!this.pen) return null;
    this.drawn.push(point);
    return {
      move: (points) => void this.drawn.push(...points),
      end: () => void (this.ended += 1),
      cancel: () => undefined,
    };
  }
  fit(): void {
    this.view = fit({ left: -0.15, right: 0.27, bottom: -0.25, top: 0.25 }, this.size, 26);
  }
  hover(): void {
    return;
  }

  /** Where the handle is in the window. */
  at(): Point {
    const [px, py] = toPixel(this.view, this.size, this.target);
    return [px + this.canvas.rect.left, py + this.canvas.rect.top];
  }
}

interface Bench {
  readonly canvas: Canvas;
  readonly plan: Plan;
  readonly pointer: PlanPointer;
}

function benchOf(): Bench {
  const canvas = new Canvas();
  const plan = new Plan(canvas);
  const pointer = new Pointer(canvas as unknown as HTMLCanvasElement, plan, plan);
  pointer.listen();
  return { canvas, plan, pointer };
}

const far = (a: Point, b: Point) => Math.hypot(a[0] - b[0], a[1] - b[1]);

test("a bar that pushes the plan down in the middle of a drag ends it, and the target stays where it was", () => {
  const { canvas, plan } = benchOf();
  const [x, y] = plan.at();
  canvas.say("pointerdown", [x, y]);
  canvas.say("pointermove", [x + 10, y]);
  const before = plan.target;
  canvas.rect = { ...canvas.rect, top: canvas.rect.top + 44, height: canvas.rect.height - 44 };
  plan.fit();
  canvas.say("pointermove", [x + 11, y]);
  canvas.say("pointermove", [x + 200, y]);
  expect(plan.target).toEqual(before);
  expect(plan.aborted).toBe(1);
  canvas.say("pointerup", [x + 200, y]);
  expect(plan.released).toBe(0);
  const handle = plan.at();
  canvas.say("pointerdown", handle);
  expect(plan.moved.at(-1)).toEqual({ point: before, fresh: true });
});

test("a drag whose pointer rests ends with the next frame after its ground changed", () => {
  const { canvas, plan, pointer } = benchOf();
  canvas.say("pointerdown", plan.at());
  pointer.check();
  expect(plan.aborted).toBe(0);
  canvas.rect = { ...canvas.rect, left: 5 };
  pointer.check();
  pointer.check();
  expect(plan.aborted).toBe(1);
});

test("a window that goes along under a resting pointer moves no target", () => {
  const { canvas, plan } = benchOf();
  const [x, y] = plan.at();
  canvas.say("pointerdown", [x, y]);
  canvas.say("pointermove", [x, y + 40], 1, [x, y + 1]);
  expect(plan.moved).toHaveLength(1);
  expect(plan.aborted).toBe(1);
});

test("the wheel does not zoom while the target is held, and a second finger neither pinches nor draws", () => {
  const { canvas, plan } = benchOf();
  const [x, y] = plan.at();
  const { view } = plan;
  canvas.say("pointerdown", [x, y]);
  canvas.say("wheel", [x, y]);
  canvas.say("pointerdown", [x + 50, y], 2);
  canvas.say("pointermove", [x + 90, y], 2);
  expect(plan.view).toBe(view);
  canvas.say("pointermove", [x + 10, y]);
  expect(plan.target[0]).toBeCloseTo(0.2 + 10 / view.scale, 12);
});

test("a stroke keeps what was drawn before its ground changed, and nothing of after", () => {
  const { canvas, plan } = benchOf();
  plan.pen = true;
  canvas.say("pointerdown", [300, 300]);
  canvas.say("pointermove", [310, 300]);
  canvas.rect = { ...canvas.rect, width: 500 };
  canvas.say("pointermove", [320, 300]);
  canvas.say("pointerup", [320, 300]);
  expect(plan.drawn).toHaveLength(2);
  expect(plan.ended).toBe(1);
});

/** Everything that may change around a press, by name so that a failure can be read. */
const CHANGES: Record<string, (bench: Bench, random: Seeded) => void> = {
  layout: ({ canvas }, random) => {
    const by = random.between(1, 60);
    canvas.rect = { ...canvas.rect, top: canvas.rect.top + by, height: canvas.rect.height - by };
  },
  scroll: ({ canvas }, random) => {
    canvas.rect = { ...canvas.rect, top: canvas.rect.top - random.between(1, 100) };
  },
  window: ({ canvas, plan }, random) => {
    around.innerWidth += Math.round(random.between(1, 100));
    canvas.rect = { ...canvas.rect, width: canvas.rect.width + random.between(-50, 50) };
    plan.fit();
  },
  browserZoom: ({ canvas, plan }, random) => {
    const zoom = random.pick([0.25, 0.5, 0.9, 1.1, 1.5, 4]);
    around.devicePixelRatio *= zoom;
    const { left, top, width, height } = canvas.rect;
    canvas.rect = { left: left / zoom, top: top / zoom, width: width / zoom, height: height / zoom };
    plan.fit();
  },
  planZoom: ({ plan }, random) => {
    plan.view = zoomAbout(plan.view, plan.size, [100, 100], random.between(1.05, 3));
  },
  pinched: (_bench, random) => {
    around.visualViewport = {
      scale: random.between(1.1, 3),
      offsetLeft: random.between(1, 50),
      offsetTop: 7,
    };
  },
};
const NAMES = Object.keys(CHANGES);

test("whatever changes in the middle of a drag, no target goes further than its pointer, and the change ends it", () => {
  for (let seed = 1; seed <= 400; seed++) {
    const random = new Seeded(seed);
    const bench = benchOf();
    const { canvas, plan, pointer } = bench;
    plan.view = zoomAbout(plan.view, plan.size, [300, 200], random.between(0.3, 20));
    plan.target = [plan.view.centre[0], plan.view.centre[1]];
    const { scale } = plan.view;
    let at = plan.at();
    const told: string[] = [];
    canvas.say("pointerdown", at);
    let over = false;
    for (let step = 0; step < 20; step++) {
      const [before, count] = [plan.target, plan.moved.length];
      if (random.next() < 0.15) {
        const name = random.pick(NAMES);
        CHANGES[name](bench, random);
        told.push(name);
        over = true;
      } else if (random.next() < 0.2) pointer.check();
      else if (random.next() < 0.1) canvas.say("wheel", at);
      else {
        const to: Point = [at[0] + random.between(-40, 40), at[1] + random.between(-40, 40)];
        canvas.say("pointermove", to);
        const why = `seed ${seed}, step ${step}, ${told.join(" ")}`;
        expect(far(plan.target, before), why).toBeLessThanOrEqual(far(to, at) / scale + 1e-12);
        if (over) expect(plan.moved, why).toHaveLength(count);
        else expect(far(plan.target, before), why).toBeCloseTo(far(to, at) / scale, 12);
        at = to;
      }
    }
    pointer.check();
    canvas.say("pointerup", at);
    expect([plan.aborted, plan.released], `seed ${seed}`).toEqual(over ? [1, 0] : [0, 1]);
  }
}, 60_000);

test.each(["mouse", "touch"])("a drag of a target that may not be moved pans nothing (%s)", (pointerType) => {
  const { canvas, plan } = benchOf();
  plan.refuses = true;
  const [view, [x, y]] = [plan.view, plan.at()];
  canvas.pointerType = pointerType;
  canvas.say("pointerdown", [x, y]);
  for (let i = 1; i <= 5; i++) canvas.say("pointermove", [x + 12 * i, y]);
  expect([plan.view, plan.moved]).toEqual([view, []]);
  canvas.say("pointerdown", [x + 90, y], 2);
  canvas.say("pointermove", [x + 140, y], 2);
  expect(plan.view, "two fingers zoom all the same").not.toEqual(view);
  for (const id of [1, 2]) canvas.say("pointerup", [x, y], id);
  plan.refuses = false;
  canvas.say("pointerdown", plan.at());
  expect(plan.moved).toHaveLength(1);
});
