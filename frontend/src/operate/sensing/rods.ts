import type { RigInfo } from "../../api/types";
import { plain } from "../../ui/format";

export const RODS = Array.from({ length: 10 }, (_, i) => i + 1);
export const bit = (rod: number) => 1 << (rod - 1);
export const ALL_RODS = 2 ** RODS.length - 1;

/** Choices of sensed rods that the paper compares. */
export const PRESETS = [
  { label: "Tip", testId: "preset-tip", sensed: bit(10), meaning: "Sense the tip alone" },
  { label: "Rod 6", testId: "preset-rod6", sensed: bit(6), meaning: "Sense rod 6 alone" },
  { label: "6 + 10", testId: "preset-6+10", sensed: bit(6) | bit(10), meaning: "Sense rod 6 and the tip" },
  {
    label: "Open loop",
    testId: "preset-openloop",
    sensed: 0,
    meaning: "Sense nothing: the observer runs on the commanded torques alone",
  },
] as const;

/** Where faults are injected: name in the menu and mask of rods. */
export const FAULTY_RODS: readonly (readonly [string, number])[] = [
  ["all rods", ALL_RODS],
  ...RODS.map((rod) => [`rod ${rod}`, bit(rod)] as const),
];

/** Mask of the rods that bear a marker: those of the rig file, and all of a twin. */
export function bearing(rods: readonly number[] | undefined): number {
  return rods === undefined ? ALL_RODS : rods.reduce((mask, rod) => mask | bit(rod), 0);
}

/** Why `sensed` cannot be sensed, null where each of its rods is `marked`. */
export function whyUnseen(sensed: number, marked: number): string | null {
  const rods = named(sensed & ~marked);
  return rods.length === 0 ? null : `No marker on rod ${rods.join(" and ")}`;
}

/** Which rods bear a marker, in a sentence. */
export function markedText(marked: number): string {
  return `Markers on rod ${named(marked).join(", ")} alone`;
}

type Bounds = Pick<RigInfo["parameters"]["controller"], "full_gains_from" | "least_gains">;

/** How much of P and I the sensed rods are worth where the tip is led by hand; null where it is all of it, or none. */
export function gainsText(sensed: number, bounds: Bounds): string | null {
  const outermost = Math.max(0, ...named(sensed));
  const share = outermost / RODS.length;
  if (outermost === 0 || share >= bounds.full_gains_from) return null;
  const percent = plain(100 * Math.max(bounds.least_gains, (share / bounds.full_gains_from) ** 2), 0);
  return `Rod ${outermost} tells little of the tip: P and I at ${percent} % in FOLLOW and HOLD`;
}

function named(mask: number): number[] {
  return RODS.filter((rod) => (mask & bit(rod)) !== 0);
}
