import type { Point } from "../api/types";
import { isPlanned, sketchOf, type DrawingState } from "../drawing/drawing";
import { chosenInfo } from "../drawing/library/references";
import { drawnShape } from "../drawing/library/shown";
import { placed, stretches } from "../drawing/piece";
import type { Page } from "../live/page";
import type { RunChoice } from "../runs/runs";
import { scene, type Lines, type SceneRole, type SceneScheme, type SceneView } from "./scene";

export type SceneLines = Readonly<Record<SceneRole, Lines>>;

const ROLES: readonly SceneRole[] = ["reference", "ghost", "outside"];
const NOTHING: SceneLines = { reference: [], ghost: [], outside: [] };
const REPORT_DELAY_MS = 150;
/** Hundredths of a millimetre are enough for a picture. */
const PER_METRE = 1e5;

/** One 3D frame as the server knows it: what is said here changes this frame alone. */
export class ViewSession {
  readonly id = sessionId();
  private wished = NOTHING;
  private told = NOTHING;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private ready = false;

  constructor(private readonly port: Pick<typeof scene, "look" | "path"> = scene) {}

  /** The frame is loaded, or the server is back: it may know nothing of what was said. */
  arrived(scheme: SceneScheme): void {
    this.ready = true;
    this.told = NOTHING;
    this.look(scheme, null);
    this.tellSoon();
  }

  look(scheme: SceneScheme, view: SceneView | null): void {
    if (this.ready) void this.port.look(this.id, { scheme, view }).catch(() => undefined); // said again on arrival
  }

  show(lines: SceneLines): void {
    this.wished = lines;
    this.tellSoon();
  }

  close(): void {
    clearTimeout(this.timer);
    this.ready = false;
  }

  private tellSoon(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.tell(), REPORT_DELAY_MS);
  }

  private async tell(): Promise<void> {
    if (!this.ready) return;
    const { wished } = this;
    const changed = ROLES.filter((role) => JSON.stringify(wished[role]) !== JSON.stringify(this.told[role]));
    this.told = wished;
    for (const role of changed) await this.port.path(this.id, role, wished[role]).catch(() => undefined);
  }
}

/** What the plan view shows as wanted and predicted. */
export function sceneLines(page: Page, drawing: DrawingState, { ghost, foreseenIn }: RunChoice): SceneLines {
  const wanted = drawing.source === "library" ? libraryLines(page) : drawingLines(drawing);
  const from = page.mode === foreseenIn ? 0 : (ghost?.start ?? 0);
  return { ...NOTHING, ...wanted, ghost: ghost ? rounded([ghost.points.slice(from)]) : [] };
}

function libraryLines(page: Page): Partial<SceneLines> {
  if (!page.reference) return {};
  return { reference: rounded([drawnShape(page.reference, chosenInfo(page)?.frequency ?? null)]) };
}

function drawingLines(drawing: DrawingState): Partial<SceneLines> {
  const { plan } = drawing;
  if (!plan || !isPlanned(drawing)) return { reference: rounded(sketchOf(drawing).pieces.map(placed)) };
  return {
    reference: rounded([plan.points]),
    outside: rounded(stretches(plan.wished, (i) => !plan.inside[i])),
  };
}

function rounded(lines: readonly (readonly Point[])[]): Lines {
  const grid = (x: number) => Math.round(x * PER_METRE) / PER_METRE;
  return lines.filter((line) => line.length > 1).map((line) => line.map(([x, y]) => [grid(x), grid(y)]));
}

function sessionId(): string {
  const digits = crypto.getRandomValues(new Uint8Array(12));
  return Array.from(digits, (digit) => (digit % 36).toString(36)).join("");
}
