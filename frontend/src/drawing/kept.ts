import type { Point } from "../api/types";
import { quietly, type PageStorage } from "../ui/storage";
import type { Drawing, Kept, Manner, Sketch, Timing } from "./drawing";
import type { Piece, Placement } from "./piece";

export const KEY = "tendril-drawing";
/** Longest text that is kept: some 50 000 points, and well under the 5 MB of a browser. */
export const CHARACTERS_MAX = 2_000_000;

/**
 * Bring back the drawing of the last visit, and keep every change that counts from now on. True if something is drawn.
 * `lost` hears, once for each drawing, why a reload will not bring it back.
 */
export function keepDrawing(drawing: Drawing, storage: PageStorage, lost: (why: string) => void): boolean {
  const last = quietly(() => parseKept(storage.getItem(KEY) ?? ""));
  if (last) drawing.restore(last);
  let shown = keptOf(drawing);
  let told = "";
  const isDrawn = shown.sketch.pieces.length > 0;
  drawing.store.subscribe(() => {
    const now = keptOf(drawing);
    if (now.sketch === shown.sketch && now.manner === shown.manner && now.name === shown.name) return;
    shown = now;
    const why = put(storage, JSON.stringify(now));
    if (why !== "" && told === "") lost(why);
    told = why;
  });
  return isDrawn;
}

/** The drawing that `text` describes; null if it is none, whatever wrote it. */
export function parseKept(text: string): Kept | null {
  const value = quietly(() => brought(JSON.parse(text) as unknown));
  return text.length <= CHARACTERS_MAX && isKept(value) ? value : null;
}

/** What a page wrote that knew one selected piece and no groups, as it is written now. */
function brought(value: unknown): unknown {
  if (!isRecord(value) || !isRecord(value.sketch) || !Array.isArray(value.sketch.pieces)) return value;
  const { pieces, selected } = value.sketch;
  const grouped = pieces.map((piece: unknown) => (isRecord(piece) ? { group: null, ...piece } : piece));
  const list = selected === null ? [] : Array.isArray(selected) ? selected : [selected];
  return { ...value, sketch: { ...value.sketch, pieces: grouped, selected: list } };
}

function keptOf(drawing: Drawing): Kept {
  const { history, manner, name } = drawing.store.get();
  return { sketch: history.present, manner, name };
}

/** Keep the drawing, or say why not: one that cannot be kept must not bring back an older one. */
function put(storage: PageStorage, text: string): string {
  quietly(() => {
    storage.removeItem(KEY);
  });
  if (text.length > CHARACTERS_MAX)
    return `It takes ${text.length} characters, more than the ${CHARACTERS_MAX} that the page keeps`;
  const kept = quietly(() => {
    storage.setItem(KEY, text);
    return true;
  });
  return kept ? "" : "This browser has no room for it";
}

function isKept(value: unknown): value is Kept {
  return (
    isRecord(value) && isSketch(value.sketch) && isManner(value.manner) && typeof value.name === "string"
  );
}

function isSketch(value: unknown): value is Sketch {
  if (!isRecord(value) || !isListOf(value.pieces, isPiece) || typeof value.closed !== "boolean") return false;
  const { pieces, selected } = value;
  return isListOf(selected, isNumber) && selected.every((i) => i in pieces);
}

function isPiece(value: unknown): value is Piece {
  if (!isRecord(value) || !isListOf(value.shape, isPoint) || value.shape.length < 2) return false;
  const { shape, placement, times, group } = value;
  const timed = times === null || (isListOf(times, isNumber) && times.length === shape.length);
  return timed && isPlacement(placement) && (group === null || isNumber(group));
}

function isPlacement(value: unknown): value is Placement {
  return (
    isRecord(value) &&
    isPoint(value.centre) &&
    isNumber(value.angle) &&
    isNumber(value.scale) &&
    value.scale > 0
  );
}

function isManner(value: unknown): value is Manner {
  if (!isRecord(value) || !isTiming(value.timing) || !isNumber(value.smoothing)) return false;
  return value.outside === "project" || value.outside === "refuse";
}

function isTiming(value: unknown): value is Timing {
  if (!isRecord(value)) return false;
  if (value.kind === "speed") return isNumber(value.speed);
  if (value.kind === "duration") return isNumber(value.duration);
  return value.kind === "fastest" || value.kind === "given";
}

function isPoint(value: unknown): value is Point {
  return isListOf(value, isNumber) && value.length === 2;
}

function isNumber(value: unknown): value is number {
  return Number.isFinite(value);
}

function isListOf<T>(value: unknown, isItem: (item: unknown) => item is T): value is T[] {
  return Array.isArray(value) && value.every(isItem);
}

function isRecord(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null;
}
