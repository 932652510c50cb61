import { usePage } from "../../live/page";
import { MODE } from "../../live/modes";

/** Why the rig cannot be started again now, null where it can. */
export function useWhyNoRestart(): string | null {
  const starting = usePage((page) => page.starting);
  const rigLive = usePage((page) => page.rigLive);
  const vented = usePage((page) => page.mode === MODE.VENTED);
  if (starting !== "") return `The rig starts with ${starting}; it comes back vented`;
  if (!rigLive) return "There is no rig";
  return vented ? null : "Disarm first: the rig starts again";
}
