import type { Cause, Law, Mode } from "../api/types";

/** Numbers of the rig's safety states (controller/schema/modes.py). */
export const MODE = {
  VENTED: 0,
  HOLD: 1,
  FOLLOW: 2,
  TRACK: 3,
  REST: 4,
  FAULT: 5,
  E_STOP: 6,
} as const satisfies Record<string, Mode>;

export const MODE_WORD: Record<Mode, string> = {
  0: "VENTED",
  1: "HOLD",
  2: "FOLLOW",
  3: "TRACK",
  4: "REST",
  5: "FAULT",
  6: "E-STOP",
};

export const MODE_MEANING: Record<Mode, string> = {
  0: "Disarmed, chambers at zero pressure",
  1: "Armed, holds the reference where it is",
  2: "Follows the target",
  3: "Follows a planned reference",
  4: "Returns to rest at a bounded rate, then vents",
  5: "Latched: returns to rest, needs Clear",
  6: "Latched: vented at once, needs Clear",
};

/** What clears a latched state: the button, and what is said about it. */
export function clearing(mode: Mode): string {
  return mode === MODE.E_STOP ? "Clear E-STOP" : "Clear fault";
}

/** The cause of what someone asked for. */
const ASKED_FOR: Cause = 1;

export const CAUSE_TEXT: Record<Cause, string> = {
  0: "",
  1: "asked for by someone",
  2: "rig started",
  3: "no sign from the operator's page",
  4: "no server",
  5: "rig's link process stalled",
  6: "no measurement",
  7: "control loop stalled",
  8: "a value was not finite",
  9: "pressure out of range",
  10: "tracking error too large",
  11: "reference finished",
  12: "came to rest",
  13: "not possible in this state",
  14: "meant for an earlier start of the rig",
  15: "no reference loaded",
  16: "no operator present",
  17: "markers frozen",
  18: "markers jumped",
  19: "chambers do not follow their pressures",
  20: "model moved too fast",
  21: "tip oscillates",
  22: "tracking error swings too widely",
  23: "observer too far from the markers",
  24: "valves' board lost",
};

/** The cause of a sign that did not reach the rig. */
const OPERATOR_LOST: Cause = 3;

/** Why the rig is in its state; of an E-STOP that was pressed, by whom, and of a sign that was missed, whose. */
export function whyText({ mode, cause, stoppedBy, missed }: Why): string {
  if (cause === OPERATOR_LOST && missed !== "") return missed;
  const pressed = mode === MODE.E_STOP && cause === ASKED_FOR && stoppedBy !== "";
  return pressed ? `by ${stoppedBy}` : CAUSE_TEXT[cause];
}

/** What `whyText` reads of the page. */
interface Why {
  readonly mode: Mode | null;
  readonly cause: Cause;
  readonly stoppedBy: string;
  readonly missed: string;
}

/** What to look at before the rig is cleared or armed again: without it the same would only happen again. */
const REMEDY: Partial<Record<Cause, string>> = {
  6: "Check camera, markers and injected faults",
  8: "Check gains and settings",
  9: "Check supply, valves and pressure sensors",
  10: "Check that nothing holds the actuator, then the gains",
  17: "Check that the camera runs and its link delivers",
  18: "Check that the camera was not moved and markers are not swapped, then the gains",
  19: "Check supply, valves and pressure sensors",
  20: "Check gains and settings",
  21: "Lower K_P, K_I or K_FF",
  22: "Lower K_P, K_I or K_FF",
  23: "Check that the actuator is the one in use, markers and camera, then K_o",
  24: "Check the valves' board, its cable and its power; the tab Rig says what is wrong",
};

export function remedy(cause: Cause): string {
  return REMEDY[cause] ?? "Find out why";
}

export const LAW_TEXT: Record<Law, string> = {
  4: "FF + PI",
  3: "FF + I",
  2: "FF + P",
  1: "FF",
  0: "Open loop",
};

/** The rig came to rest because of its gains: armed again with the same ones, it would do the same. */
export function isSwing(cause: Cause): boolean {
  return cause === 21 || cause === 22;
}

/** Causes that an operator expects: they did it, or it is how things begin and end. */
const EXPECTED: readonly Cause[] = [0, 1, 2, 11, 12];

/** The rig changed its state by itself: its cause is then shown beside the state. */
export function isUnasked(cause: Cause): boolean {
  return !EXPECTED.includes(cause);
}

/** Latched states need Clear. */
export function isLatched(mode: Mode): boolean {
  return mode === MODE.FAULT || mode === MODE.E_STOP;
}

/** The operator may move the target. */
export function isMovable(mode: Mode): boolean {
  return mode === MODE.HOLD || mode === MODE.FOLLOW || mode === MODE.TRACK;
}

/** `value` as a mode, or null if this page does not know it. */
export function asMode(value: number): Mode | null {
  return value in MODE_WORD ? (value as Mode) : null;
}

/** `value` as a cause; an unknown one reads as none. */
export function asCause(value: number): Cause {
  return value in CAUSE_TEXT ? (value as Cause) : 0;
}
