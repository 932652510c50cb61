export type Action =
  | { kind: "hold" }
  | { kind: "e_stop" }
  | { kind: "follow" }
  | { kind: "record" }
  | { kind: "mark" }
  | { kind: "help" }
  | { kind: "pause" }
  | { kind: "step" }
  | { kind: "view" }
  | { kind: "panel"; place: number }
  | { kind: "nudge"; dx: number; dy: number; fresh: boolean }
  | { kind: "release" };

/** The part of a KeyboardEvent that decides, and whether the focus takes text or arrows itself. */
export interface Press {
  readonly key: string;
  readonly shiftKey: boolean;
  readonly ctrlKey: boolean;
  readonly altKey: boolean;
  readonly metaKey: boolean;
  readonly repeat: boolean;
}

export type Focus = "page" | "text" | "widget";

const DOUBLE_MS = 1000;
const STEP_M = 1e-3;
const ARROWS: Partial<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/** Turns keys into actions; remembers the last Esc, because two within 1 s are an E-STOP, and the arrows that are held. */
export class KeyMap {
  private lastEscape = -Infinity;
  private readonly arrows = new Set<string>();

  /** `now` in milliseconds of any steady clock; null: the press is not ours. */
  press(event: Press, focus: Focus, now: number): Action | null {
    if (event.key === "Escape") return event.repeat ? null : this.escape(now);
    if (event.altKey || event.metaKey || focus === "text") return null;
    const arrow = ARROWS[event.key];
    if (arrow) return focus === "page" ? this.nudge(arrow, event) : null;
    if (event.ctrlKey || event.repeat) return null;
    return letter(event.key);
  }

  /** A key came up: the last arrow lets go of the target. */
  lift(key: string): Action | null {
    return this.arrows.delete(key) && this.arrows.size === 0 ? { kind: "release" } : null;
  }

  /** The window no longer hears keys: whatever was held counts as let go. */
  liftAll(): Action | null {
    const held = this.arrows.size > 0;
    this.arrows.clear();
    return held ? { kind: "release" } : null;
  }

  private nudge([x, y]: readonly [number, number], event: Press): Action {
    const step = STEP_M * (event.shiftKey ? 10 : event.ctrlKey ? 0.1 : 1);
    this.arrows.add(event.key);
    return { kind: "nudge", dx: x * step, dy: y * step, fresh: !event.repeat };
  }

  private escape(now: number): Action {
    const twice = now - this.lastEscape <= DOUBLE_MS;
    this.lastEscape = twice ? -Infinity : now;
    return { kind: twice ? "e_stop" : "hold" };
  }
}

function letter(key: string): Action | null {
  switch (key) {
    case "f":
    case "F":
      return { kind: "follow" };
    case "r":
    case "R":
      return { kind: "record" };
    case "b":
    case "B":
      return { kind: "mark" };
    case "p":
    case "P":
      return { kind: "pause" };
    case ".":
      return { kind: "step" };
    case "?":
      return { kind: "help" };
    case "v":
    case "V":
      return { kind: "view" };
    default:
      return /^[1-9]$/.test(key) ? { kind: "panel", place: Number(key) } : null;
  }
}

/** Keys that hold in one place, each with what it does. */
interface KeyGroup {
  readonly where: string;
  readonly keys: readonly (readonly [string, string])[];
}

/** What the focused element does with keys of its own. */
export function focusOf(element: Element | null): Focus {
  if (!element || element === document.body || element.hasAttribute("data-plan")) return "page";
  if (
    element.matches(
      "input:not([type=checkbox], [type=radio], [type=range]), textarea, select, [contenteditable=true]",
    )
  )
    return "text";
  return "widget";
}

/** All keys and gestures, by where they hold. */
export const KEY_LIST: readonly KeyGroup[] = [
  {
    where: "Everywhere, in every field",
    keys: [
      ["Esc", "HOLD; where a dialog, a menu or a line being drawn is open, it closes that and no more"],
      ["Esc Esc", "E-STOP (twice within 1 s); what closes something does not count"],
    ],
  },
  {
    where: "Wherever no text is being typed",
    keys: [
      ["F", "Follow the target"],
      ["R", "Start or stop a recording"],
      ["B", "Bookmark the newest row of the recording; then type its label, Enter"],
      ["P", "Pause the twin, or let it go on; while it is paused . lets it take a step"],
      ["1–9", "Go to the panel at that place: 1 is Control, 2 is Run"],
      ["V", "Go to Review, or back to Live"],
      ["?", "Show or hide this list"],
      ["Gamepad", "Hold A (or the right shoulder) and steer with the left stick; B = HOLD"],
    ],
  },
  {
    where: "Plan",
    keys: [
      [
        "Arrows",
        "Move the target 1 mm (Shift 10 mm, Ctrl 0.1 mm); with Select, what is selected of the drawing",
      ],
      ["Drag", "The target, a piece of the drawing, or empty space to pan"],
      ["Wheel", "Or two fingers: zoom; double-click fits all"],
    ],
  },
  {
    where: "Drawing",
    keys: [
      ["Ctrl Z", "Undo a change (Ctrl Shift Z or Ctrl Y: redo)"],
      ["Ctrl A", "Select all, after a click on the plan"],
      ["Shift", "Select several: with a click on a piece, or a box drawn with Select"],
      ["Ctrl G", "Group what is selected (Ctrl Shift G: ungroup)"],
      ["Del", "Take away what is selected"],
      ["Enter", "End the line that is being drawn"],
    ],
  },
  {
    where: "Plots",
    keys: [
      ["Wheel", "Up and down: zoom about the pointer; with Shift: move in time; or one and two fingers"],
      ["Drag", "Zoom into a span; double-click shows all again"],
    ],
  },
  {
    where: "Commissioning of a rig",
    keys: [["Space", "Held on a chamber's button: fill it; letting go empties it"]],
  },
  {
    where: "Recordings",
    keys: [
      ["↑ ↓", "From row to row of the list"],
      ["Enter", "Open the recording, on its name"],
      ["Space", "Tick it for the comparison, on its box"],
      ["Ctrl Z", "Bring back what was deleted last, while the page offers it"],
    ],
  },
];
