import { api, dataOf } from "../api/rest";
import type { components } from "../api/schema";

type Schemas = components["schemas"];

export type SeatLook = Schemas["SeatLook"];
export type Playback = Schemas["Playback"];
export type PlaybackBody = Schemas["PlaybackBody"];
export type SceneView = "top" | "oblique";
export type SceneScheme = SeatLook["scheme"];
export type SceneRole = "reference" | "ghost" | "outside";
/** Points of each line of a path [m]. */
export type Lines = Schemas["SeatPath"]["lines"];

/** What a page says about its own 3D view. */
export const scene = {
  look: (seat: string, body: SeatLook): Promise<unknown> =>
    api.PUT("/api/scene/{seat}/look", { params: { path: { seat } }, body }),
  path: (seat: string, role: SceneRole, lines: Lines): Promise<unknown> =>
    api.PUT("/api/scene/{seat}/path/{role}", { params: { path: { seat, role } }, body: { lines } }),
  play: (seat: string, body: PlaybackBody) =>
    dataOf(api.PUT("/api/scene/{seat}/playback", { params: { path: { seat } }, body })),
};

/** Address of viser's page on this seat. */
export function sceneUrl(seat: string, view: SceneView, scheme: SceneScheme): string {
  return `/viser/seat/${seat}/?view=${view}&scheme=${scheme}`;
}
