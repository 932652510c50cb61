import { call } from "../api/rest";
import type { components } from "../api/schema";

export type TwinFaults = components["schemas"]["TwinFaults-Output"];

/** Faults of the twin, live. */
export const twin = {
  faults: () => call<TwinFaults>("GET", "/api/twin/faults"),
  inject: (faults: TwinFaults) => call<TwinFaults>("PUT", "/api/twin/faults", faults),
};
