import { call } from "../api/rest";
import type { components } from "../api/schema";

type Schemas = components["schemas"];

export type GainPreset = Schemas["GainPreset"];
export type ActuatorChoice = Schemas["ActuatorChoice"];
export type ActuatorBody = Schemas["ActuatorBody"];

const gains = (name: string) => `/api/gains/${encodeURIComponent(name)}`;

/** Presets of gains, and the choice of the actuator. */
export const presets = {
  gains: () => call<GainPreset[]>("GET", "/api/gains"),
  save: (name: string) => call<GainPreset[]>("PUT", gains(name)),
  remove: (name: string) => call<GainPreset[]>("DELETE", gains(name)),
  actuators: () => call<ActuatorChoice>("GET", "/api/rig/actuator"),
  change: (body: ActuatorBody) => call<null>("PUT", "/api/rig/actuator", body),
};
