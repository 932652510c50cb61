import type { Mode } from "../api/types";
import { isLatched, isMovable, MODE, MODE_WORD } from "./modes";

export type Control =
  | "take"
  | "release"
  | "arm"
  | "disarm"
  | "hold"
  | "follow"
  | "clear"
  | "drag"
  | "run"
  | "settings"
  | "record"
  | "e_stop";

/** What decides whether a control works now. */
export interface Situation {
  readonly online: boolean;
  readonly rigLive: boolean;
  readonly mode: Mode | null;
  readonly mine: boolean;
  readonly held: boolean;
  readonly holder: string;
  readonly recording: boolean;
}

/** Why `control` does not work now, as one sentence; null when it does. E-STOP is never refused. */
export function whyNot(control: Control, now: Situation): string | null {
  if (control === "e_stop") return null;
  if (!now.online) return "No connection to the server";
  if (control === "take") return whyNotTake(now);
  if (!now.mine) return now.held ? `${now.holder} operates` : "Take control first";
  if (control === "release" || control === "settings") return null;
  if (control === "record" && now.recording) return null;
  if (!now.rigLive || now.mode === null) return "The rig does not answer";
  return whyNotInMode(control, now.mode);
}

function whyNotTake(now: Situation): string | null {
  if (now.mine) return "You operate already";
  return now.held ? `${now.holder} operates` : null;
}

function whyNotInMode(control: Control, mode: Mode): string | null {
  switch (control) {
    case "arm":
      return mode === MODE.VENTED ? null : isLatched(mode) ? "Clear first" : "Armed already";
    case "disarm":
      return isMovable(mode) ? null : notIn(mode);
    case "hold":
      return mode === MODE.HOLD
        ? "Holds already"
        : isMovable(mode) || mode === MODE.REST
          ? null
          : notIn(mode);
    case "follow":
    case "drag":
      return isMovable(mode) ? null : mode === MODE.VENTED ? "Arm first" : notIn(mode);
    case "run":
      if (mode === MODE.TRACK) return "A reference runs already";
      return isMovable(mode) ? null : mode === MODE.VENTED ? "Arm first" : notIn(mode);
    case "clear":
      return isLatched(mode) ? null : "Nothing is latched";
    case "take":
    case "release":
    case "settings":
    case "record":
    case "e_stop":
      return null;
  }
}

function notIn(mode: Mode): string {
  if (isLatched(mode)) return "Clear first";
  return mode === MODE.REST ? "The rig is returning to rest" : `Not possible in ${MODE_WORD[mode]}`;
}
