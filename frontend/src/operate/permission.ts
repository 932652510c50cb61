import type { Mode, Role } from "../api/types";
import { silenceOf, usePage, type Page } from "../live/page";
import { isLatched, isMovable, MODE, MODE_WORD } from "../live/modes";

/** What depends on the rig's state. */
type OfRig = "arm" | "disarm" | "hold" | "follow" | "clear" | "drag" | "run" | "record" | "mark" | "time";
export type Control = OfRig | "take" | "take_over" | "ask" | "release" | "settings" | "edit" | "e_stop";

/** What decides whether a control works now. */
export interface Situation {
  readonly online: boolean;
  readonly unheard: boolean;
  readonly rigLive: boolean;
  /** Actuator with which the rig is being started, "" for none. */
  readonly starting: string;
  readonly mode: Mode | null;
  readonly mine: boolean;
  readonly held: boolean;
  readonly holder: string;
  readonly clutch: boolean;
  readonly recording: boolean;
  readonly role: Role;
  /** The rig is a twin, and whether its time stands still. */
  readonly twin: boolean;
  readonly paused: boolean;
  /** Of a rig of devices whose frame, signs or chambers no one has accepted: its commissioning alone arms it. */
  readonly uncommissioned: boolean;
  /** A macro runs. */
  readonly macro: boolean;
  /** No one touched the page for as long as its user chose. */
  readonly locked: boolean;
}

/** The part of the page that decides what is allowed. */
export function situation(page: Page): Situation {
  const { online, unheard, rigLive, mode, lease, me, recording, locked } = page;
  const macro = page.macro?.state === "running";
  const [starting, twin] = [page.starting, page.rig?.twin === true];
  return {
    online,
    unheard,
    rigLive,
    starting,
    mode,
    ...lease,
    role: me.role,
    recording: recording.recording,
    locked,
    macro,
    twin,
    uncommissioned: page.rig?.parameters.hardware?.commissioned === "missing",
    paused: isPaused(page),
  };
}

/** The twin's time stands still: nothing new comes, and nothing is wrong. */
export function isPaused({ online, rigLive, health }: Pick<Page, "online" | "rigLive" | "health">): boolean {
  return online && rigLive && health?.paused === true;
}

/** Why `control` does not work now; null when it does. */
export function useWhyNot(control: Control): string | null {
  return usePage((page) => whyNot(control, situation(page)));
}

/** What a paused twin cannot begin. */
const BEGINNINGS = new Set<Control>(["arm", "follow", "clear", "drag", "run"]);
/** Why Follow alone does nothing while the held clutch is on. */
const CLUTCHED = "Held clutch is on: hold the target, an arrow key or the gamepad's button";
const UNCOMMISSIONED = "Not commissioned: accept drivers, chambers, frame and signs first (Rig tab)";
/** Why a viewer's session may not. */
const LOOKING = "The viewer's token is for looking and for the E-STOP";

/** Why `control` does not work now, as one sentence; null when it does. E-STOP is never refused, and no lock keeps from Hold. */
export function whyNot(control: Control, now: Situation): string | null {
  if (control === "e_stop") return null;
  if (now.locked && control !== "hold") return "The page is locked: unlock it first";
  if (silenceOf(now) === "server") return "No connection to the server";
  if (control === "take") return whyNotTake(now);
  if (control === "take_over" || control === "ask") return whyNotGet(control, now);
  if (control === "edit") return now.mine ? null : whyNotByRole(now);
  if (!now.mine) return now.held ? `${now.holder} operates` : (whyNotByRole(now) ?? "Take control first");
  if (control === "release" || control === "settings") return null;
  if (control === "hold" && now.macro) return null; // it ends the macro, whatever the rig does
  if (control === "mark") return now.recording ? null : "Nothing is recorded now";
  if (control === "record" && now.recording) return null;
  if (now.starting !== "") return `The rig starts with actuator ${now.starting}`;
  if (!now.rigLive || now.mode === null) return "The rig does not answer";
  if (control === "time") return now.twin ? null : "Only a twin's time can stand still: this rig is hardware";
  if (now.paused && BEGINNINGS.has(control)) return "The twin is paused: let it go on first (P)";
  if (control === "arm" && now.uncommissioned && now.mode === MODE.VENTED) return UNCOMMISSIONED;
  return whyNotInMode(control, now.mode) ?? (control === "follow" && now.clutch ? CLUTCHED : null);
}

function whyNotTake(now: Situation): string | null {
  if (now.mine) return "You operate already";
  return now.held ? `${now.holder} operates` : whyNotByRole(now);
}

function whyNotGet(control: "take_over" | "ask", now: Situation): string | null {
  if (now.mine) return "You operate already";
  if (!now.held) return "No one operates";
  return control === "ask" ? null : whyNotByRole(now);
}

function whyNotByRole({ role }: Situation): string | null {
  return role === "viewer" ? LOOKING : null;
}

function whyNotInMode(control: OfRig, mode: Mode): string | null {
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
    case "run":
    case "follow":
    case "drag":
      if (control === "run" && mode === MODE.TRACK) return "A reference runs already";
      return isMovable(mode) ? null : mode === MODE.VENTED ? "Arm first" : notIn(mode);
    case "clear":
      return isLatched(mode) ? null : "Nothing is latched";
    case "record":
    case "mark":
    case "time":
      return null;
  }
}

function notIn(mode: Mode): string {
  if (isLatched(mode)) return "Clear first";
  return mode === MODE.REST ? "The rig is returning to rest" : `Not possible in ${MODE_WORD[mode]}`;
}
