import { call } from "../api/rest";
import type { components } from "../api/schema";
import type { Point } from "../api/types";

type Schemas = components["schemas"];

export type SeatLook = Schemas["SeatLook"];
export type Playback = Schemas["Playback"];
export type PlaybackBody = Schemas["PlaybackBody"];
export type SceneView = "top" | "oblique";
export type SceneScheme = SeatLook["scheme"];
export type SceneRole = "reference" | "ghost" | "outside";
/** Points of each line of a path [m]. */
export type Lines = readonly (readonly Point[])[];

const at = (seat: string) => `/api/scene/${seat}`;

/** What a page says about its own 3D view. */
export const scene = {
  look: (seat: string, body: SeatLook) => call<null>("PUT", `${at(seat)}/look`, body),
  path: (seat: string, role: SceneRole, lines: Lines) =>
    call<null>("PUT", `${at(seat)}/path/${role}`, { lines }),
  play: (seat: string, body: PlaybackBody) => call<Playback>("PUT", `${at(seat)}/playback`, body),
};

/** Address of viser's page on this seat. */
export function sceneUrl(seat: string, view: SceneView, scheme: SceneScheme): string {
  return `/viser/seat/${seat}/?view=${view}&scheme=${scheme}`;
}
