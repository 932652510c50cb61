import type { ControllerInfo } from "../../api/types";

/** The controller's own numbers by name: `tuning` has them in the order of its definition, and zeros after them. */
export function numbersOf(controller: ControllerInfo, tuning: readonly number[]): Record<string, number> {
  return Object.fromEntries(controller.tuning.map(({ name, usual }, i) => [name, tuning[i] ?? usual]));
}
