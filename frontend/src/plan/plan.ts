import type { Point, Workspace } from "../api/types";
import { Drawing } from "../drawing/drawing";
import { Live } from "../live/live";
import { PageStore } from "../live/page";
import { TargetControl } from "../operate/target/targetControl";
import { Runs } from "../runs/runs";
import { RunTrace } from "../runs/trace";
import { INK, type Scheme } from "../ui/colours";
import { Painters } from "../ui/painters";
import type { Services } from "../ui/services";
import { Ticker } from "../ui/ticker";
import { Layers } from "./layers";
import { resize, sheetOf, type Look, type Sheet } from "./paint/canvas";
import { handleRadius } from "./paint/figure";
import { FigureLayer } from "./paint/figureLayer";
import { paintPaper, reachOf, type Reach } from "./paint/paper";
import { reachQuads } from "./paint/reach";
import { SketchLayer } from "./paint/sketchLayer";
import { gestureOf, type Gesture } from "./pointer/pens";
import { PlanPointer, type PlanSurface } from "./pointer/pointer";
import { boundingBox, fit, toPixel, toPlane, type Box, type Size, type View } from "./transform";

const FIT_MARGIN_PX = 26;
const FIRST_BOX: Box = { left: -0.15, right: 0.27, bottom: -0.25, top: 0.25 };
const BODY_WIDTH_M = 0.03;
const HANDLE_EXTRA_PX = 7;
const FINGER_PX = 24;

/** What of the plan is painted by itself, as an operator knows it. */
const LAYERS = {
  paper: { name: "grid of the plan" },
  sketch: { name: "path in the plan" },
  figure: { name: "actuator in the plan" },
};

/** The plan's canvases, lowest first. */
export interface Canvases {
  /** Grid and reach: painted when the view changes. */
  readonly paper: HTMLCanvasElement;
  /** What is wanted and predicted: painted when it changes. */
  readonly sketch: HTMLCanvasElement;
  /** The actuator: painted when it moves. It takes the pointer. */
  readonly figure: HTMLCanvasElement;
}

/** The plan view behind its canvases. */
export class Plan implements PlanSurface {
  onHover: (point: Point | null) => void = () => undefined;
  private look: Look = {
    view: { centre: [0, 0], scale: 1000 },
    size: { width: 1, height: 1 },
    scheme: "dark",
    ratio: devicePixelRatio,
    hidden: new Set(),
  };
  /** How the paper was looked at when it was painted; null when it must be painted. */
  private paperLook: Look | null = null;
  private fitted = true;
  private box = FIRST_BOX;
  private reach: Reach | null = null;
  private workspace: Workspace | null = null;
  private readonly sketch: SketchLayer;
  /** False behind the review. */
  private seen = true;
  private readonly figure = new FigureLayer();
  private readonly canvas: HTMLCanvasElement;
  private readonly targetControl: TargetControl;
  private readonly drawn: Drawing;
  private readonly live: Live;
  private readonly page: PageStore;
  private readonly painters: Painters;
  private readonly layers: Layers;

  constructor(
    private readonly services: Services,
    private readonly canvases: Canvases,
  ) {
    this.targetControl = services.get(TargetControl);
    this.drawn = services.get(Drawing);
    this.live = services.get(Live);
    this.page = services.get(PageStore);
    this.painters = services.get(Painters);
    this.layers = services.get(Layers);
    this.canvas = canvases.figure;
    this.sketch = new SketchLayer(this.drawn, services.get(Runs), services.get(RunTrace), this.page);
  }

  /** Follow stream, size and pointer until the returned function is called. */
  start(): () => void {
    const sizes = new ResizeObserver(([entry]) => {
      this.resized({ width: entry.contentRect.width, height: entry.contentRect.height });
    });
    sizes.observe(this.canvas);
    const pointer = new PlanPointer(this.canvas, this, this.targetControl);
    const listening = new AbortController();
    // A canvas that the browser took away comes back empty.
    for (const canvas of [this.canvases.paper, this.canvases.sketch, this.canvases.figure])
      canvas.addEventListener("contextrestored", () => this.change({}), listening); // prettier-ignore
    const stops = [
      this.services.get(Ticker).every(60, "plan", (now) => {
        pointer.check();
        if (this.seen) this.paint(now);
      }),
      pointer.listen(),
      () => {
        sizes.disconnect();
        listening.abort();
      },
    ];
    return () => {
      for (const stop of stops) stop();
    };
  }

  get view(): View {
    return this.look.view;
  }

  set view(view: View) {
    this.change({ view });
    this.fitted = false;
  }

  get size(): Size {
    return this.look.size;
  }

  useScheme(scheme: Scheme): void {
    this.change({ scheme });
  }

  fit(): void {
    this.change({ view: fit(this.box, this.size, FIT_MARGIN_PX) });
    this.fitted = true;
  }

  handleReach(touch: boolean): number {
    const radius = handleRadius(this.view.scale) + HANDLE_EXTRA_PX;
    return touch ? Math.max(FINGER_PX, radius) : radius;
  }

  drawing(): boolean {
    return this.drawn.store.get().tool !== "drag";
  }

  grab(point: Point, reach: number, adds: boolean): Gesture | null {
    const { scale } = this.view;
    const press = { point, reach: reach / scale, scale, adds: adds || this.drawn.store.get().several };
    return gestureOf(this.drawn, press);
  }

  hover(point: Point | null, overHandle: boolean): void {
    this.canvas.style.cursor = this.drawing() ? "crosshair" : overHandle ? "grab" : "";
    this.sketch.cursor = point;
    this.onHover(point);
  }

  /** Position on the screen [CSS px of the window] of a point of the plane [m]. */
  clientOf(point: Point): Point {
    const bounds = this.canvas.getBoundingClientRect();
    const [px, py] = toPixel(this.view, this.size, point);
    return [bounds.left + px, bounds.top + py];
  }

  /** Where the target's handle is drawn on the plan [px]; null without one, or where it is out of the picture. */
  handleAt(): Point | null {
    const handle = this.targetControl.handle(performance.now());
    if (!handle) return null;
    const { width, height } = this.size;
    const [x, y] = toPixel(this.view, this.size, handle.point);
    return x >= 0 && y >= 0 && x <= width && y <= height ? [x, y] : null;
  }

  /** Point of the plane [m] at a position on the screen. */
  planeOf([clientX, clientY]: Point): Point {
    const bounds = this.canvas.getBoundingClientRect();
    return toPlane(this.view, this.size, [clientX - bounds.left, clientY - bounds.top]);
  }

  private resized(size: Size): void {
    this.seen = size.width >= 2 && size.height >= 2;
    if (!this.seen) return;
    this.change({ size });
    if (this.fitted) this.fit();
  }

  /** Look at the plan in another way; every layer is then painted. */
  private change(change: Partial<Look>): void {
    this.look = { ...this.look, ...change };
  }

  /** Paint what is new, layer by layer: whichever fails, the others are painted. */
  private paint(frame: number): void {
    const { painters, canvases } = this;
    this.follow(this.page.get().workspace);
    if (this.look.ratio !== devicePixelRatio) this.change({ ratio: devicePixelRatio });
    const { hidden } = this.layers.store.get();
    if (this.look.hidden !== hidden) this.change({ hidden });
    painters.run(LAYERS.paper, frame, () => {
      this.paintPaper();
    });
    painters.run(LAYERS.sketch, frame, () => {
      this.sketch.paint(this.look, () => this.sheet(canvases.sketch));
    });
    painters.run(LAYERS.figure, frame, () => {
      this.paintFigure();
    });
  }

  private paintFigure(): void {
    const { targetControl, live, page } = this;
    const { telemetry, trail, frames } = live;
    if (!telemetry) return;
    const now = performance.now();
    const width = page.get().rig?.parameters.actuator.width ?? BODY_WIDTH_M;
    const figure = { telemetry, trail, frames, width, handle: targetControl.handle(now), now: now / 1e3 };
    this.figure.paint(this.look, figure, () => this.sheet(this.canvas));
  }

  private paintPaper(): void {
    const { look } = this;
    if (this.paperLook === look) return;
    const sheet = this.sheet(this.canvases.paper);
    if (sheet) paintPaper(sheet, look.hidden.has("reach") ? null : this.reach, look.ratio);
    this.paperLook = look;
  }

  private sheet(canvas: HTMLCanvasElement): Sheet | null {
    const { view, size, scheme, ratio } = this.look;
    const g = resize(canvas, size, ratio);
    return g && sheetOf(g, view, size, INK[scheme]);
  }

  private follow(workspace: Workspace | null): void {
    if (workspace === this.workspace) return;
    this.workspace = workspace;
    this.reach = workspace && reachOf(reachQuads(workspace), workspace.points);
    this.box = (workspace && boundingBox(workspace.points)) ?? FIRST_BOX;
    this.change({});
    if (this.fitted) this.fit();
  }
}
