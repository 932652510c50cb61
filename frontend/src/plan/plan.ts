import type { Point, Workspace } from "../api/types";
import { Drawing } from "../drawing/drawing";
import { Live } from "../live/live";
import { PageStore } from "../live/page";
import { Aim } from "../operate/target/aim";
import type { Wish } from "../operate/target/handle";
import { Runs } from "../runs/runs";
import { INK, type Scheme } from "../ui/colours";
import { Painters } from "../ui/painters";
import type { Services } from "../ui/services";
import { Ticker } from "../ui/ticker";
import { resize, sheetOf, type Sheet } from "./paint/canvas";
import { handleRadius, paintFigure } from "./paint/figure";
import { paintPaper, reachOf, type Reach } from "./paint/paper";
import { reachQuads } from "./paint/reach";
import { SketchLayer } from "./paint/sketchLayer";
import { gestureOf, type Gesture } from "./pointer/pens";
import { PlanPointer, type PlanSurface } from "./pointer/pointer";
import { boundingBox, fit, pan, toPixel, toPlane, type Box, type Size, type View } from "./transform";

const FIT_MARGIN_PX = 26;
/** Height of what stands over the top of the plan. */
const TOOLS_PX = 30;
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
  /** The actuator: painted per frame. It takes the pointer. */
  readonly figure: HTMLCanvasElement;
}

/** The plan view behind its canvases. */
export class Plan implements PlanSurface {
  size: Size = { width: 1, height: 1 };
  onHover: (point: Point | null) => void = () => undefined;
  private shown: View = { centre: [0, 0], scale: 1000 };
  private fitted = true;
  private box = FIRST_BOX;
  private reach: Reach | null = null;
  private workspace: Workspace | null = null;
  private readonly sketch: SketchLayer;
  private readonly canvas: HTMLCanvasElement;
  private scheme: Scheme = "dark";
  private paperDirty = true;
  private paintedFrames = -1;
  private paintedWish: Wish | null = null;
  private readonly aim: Aim;
  private readonly drawn: Drawing;
  private readonly live: Live;
  private readonly page: PageStore;
  private readonly painters: Painters;

  constructor(
    private readonly services: Services,
    private readonly canvases: Canvases,
  ) {
    this.aim = services.get(Aim);
    this.drawn = services.get(Drawing);
    this.live = services.get(Live);
    this.page = services.get(PageStore);
    this.painters = services.get(Painters);
    this.canvas = canvases.figure;
    this.sketch = new SketchLayer(this.drawn, services.get(Runs), this.page);
  }

  /** Follow stream, size and pointer until the returned function is called. */
  start(): () => void {
    const sizes = new ResizeObserver(([entry]) => {
      this.resized({ width: entry.contentRect.width, height: entry.contentRect.height });
    });
    sizes.observe(this.canvas);
    const pointer = new PlanPointer(this.canvas, this, this.aim);
    const stops = [
      this.services.get(Ticker).every(60, "plan", (now) => {
        pointer.check();
        this.paint(now);
      }),
      pointer.listen(),
      () => {
        sizes.disconnect();
      },
    ];
    return () => {
      for (const stop of stops) stop();
    };
  }

  get view(): View {
    return this.shown;
  }

  set view(view: View) {
    this.shown = view;
    this.fitted = false;
    this.paperDirty = true;
  }

  useScheme(scheme: Scheme): void {
    this.scheme = scheme;
    this.paperDirty = true;
  }

  fit(): void {
    const { width, height } = this.size;
    this.shown = pan(fit(this.box, { width, height: height - TOOLS_PX }, FIT_MARGIN_PX), 0, TOOLS_PX / 2);
    this.fitted = true;
    this.paperDirty = true;
  }

  handleReach(touch: boolean): number {
    const radius = handleRadius(this.shown.scale) + HANDLE_EXTRA_PX;
    return touch ? Math.max(FINGER_PX, radius) : radius;
  }

  drawing(): boolean {
    return this.drawn.store.get().tool !== "drag";
  }

  grab(point: Point, reach: number): Gesture | null {
    const { scale } = this.shown;
    return gestureOf(this.drawn, { point, reach: reach / scale, scale });
  }

  hover(point: Point | null, overHandle: boolean): void {
    this.canvas.style.cursor = this.drawing() ? "crosshair" : overHandle ? "grab" : "";
    this.sketch.cursor = point;
    this.onHover(point);
  }

  /** Position on the screen [CSS px of the window] of a point of the plane [m]. */
  clientOf(point: Point): Point {
    const bounds = this.canvas.getBoundingClientRect();
    const [px, py] = toPixel(this.shown, this.size, point);
    return [bounds.left + px, bounds.top + py];
  }

  /** Point of the plane [m] at a position on the screen. */
  planeOf([clientX, clientY]: Point): Point {
    const bounds = this.canvas.getBoundingClientRect();
    return toPlane(this.shown, this.size, [clientX - bounds.left, clientY - bounds.top]);
  }

  private resized(size: Size): void {
    if (size.width < 2 || size.height < 2) return;
    this.size = size;
    this.paperDirty = true;
    if (this.fitted) this.fit();
  }

  /** Paint what is new, layer by layer: whichever fails, the others are painted. */
  private paint(frame: number): void {
    const { aim, live, page, painters } = this;
    this.follow(page.get().workspace);
    const paperDirty = this.paperDirty;
    if (paperDirty)
      painters.run(LAYERS.paper, frame, () => {
        this.paintPaper();
      });
    painters.run(LAYERS.sketch, frame, () => {
      this.sketch.paint([this.shown, this.size, this.scheme], () => this.sheet(this.canvases.sketch));
    });
    if (paperDirty || this.paintedFrames !== live.frames || this.paintedWish !== aim.wanted)
      painters.run(LAYERS.figure, frame, () => {
        this.paintFigure();
      });
  }

  private paintFigure(): void {
    const { aim, live, page } = this;
    const sheet = this.sheet(this.canvas);
    if (!sheet || !live.telemetry) return;
    sheet.g.clearRect(0, 0, this.size.width, this.size.height);
    const now = performance.now();
    const width = page.get().rig?.parameters.actuator.width ?? BODY_WIDTH_M;
    const { telemetry, trail } = live;
    paintFigure(sheet, { telemetry, trail, width, handle: aim.handle(now), now: now / 1e3 });
    this.paintedFrames = live.frames;
    this.paintedWish = aim.wanted;
  }

  private paintPaper(): void {
    const sheet = this.sheet(this.canvases.paper);
    if (sheet) paintPaper(sheet, this.reach, devicePixelRatio);
    this.paperDirty = false;
  }

  private sheet(canvas: HTMLCanvasElement): Sheet | null {
    const g = resize(canvas, this.size, devicePixelRatio);
    return g && sheetOf(g, this.shown, this.size, INK[this.scheme]);
  }

  private follow(workspace: Workspace | null): void {
    if (workspace === this.workspace) return;
    this.workspace = workspace;
    this.reach = workspace && reachOf(reachQuads(workspace), workspace.points);
    this.box = (workspace && boundingBox(workspace.points)) ?? FIRST_BOX;
    this.paperDirty = true;
    if (this.fitted) this.fit();
  }
}
