import { api, dataOf } from "../../api/rest";
import type { components } from "../../api/schema";

export type TwinFaults = components["schemas"]["TwinFaults-Output"];

/** Faults of the twin, live. */
export const twin = {
  faults: () => dataOf(api.GET("/api/twin/faults")),
  inject: (faults: TwinFaults) => dataOf(api.PUT("/api/twin/faults", { body: faults })),
};
