import { api, named, dataOf } from "../../api/rest";
import type { components } from "../../api/schema";

type Schemas = components["schemas"];

export type GainPreset = Schemas["GainPreset"];
export type ActuatorChoice = Schemas["ActuatorChoice"];
export type ActuatorBody = Schemas["ActuatorBody"];
export type PlantBody = Schemas["PlantBody"];
export type Plant = PlantBody["plant"];

/** An actuator or a plant that was chosen: said by name, asked for by its body. */
export interface Wanted {
  readonly name: string;
  readonly body: ActuatorBody | PlantBody;
}

/** Presets of gains, and the choice of actuator and plant. */
export const presets = {
  gains: () => dataOf(api.GET("/api/gains")),
  save: (name: string) => dataOf(api.PUT("/api/gains/{name}", named(name))),
  remove: (name: string) => dataOf(api.DELETE("/api/gains/{name}", named(name))),
  actuators: () => dataOf(api.GET("/api/rig/actuator")),
  plant: (body: PlantBody) => api.PUT("/api/rig/plant", { body }),
  observerKappa: (kappa: number) => api.PUT("/api/rig/observer-kappa", { body: { kappa } }),
  change: (body: ActuatorBody) => api.PUT("/api/rig/actuator", { body }),
};
