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
