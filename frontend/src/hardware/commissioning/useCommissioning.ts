import { useRef } from "react";
import { usePage } from "../../live/page";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { useTick } from "../../ui/ticker";
import { Commissioning, isHardware } from "./commissioning";
import type { CommissioningState } from "./steps";

export function useCommissioningState(): CommissioningState | null {
  const { store } = useService(Commissioning);
  return useStore(store, ({ state }) => state);
}

/** Look at it so often while the page is in sight: other pages and the rig change it, too. */
export function useRefresh(perSecond: number): void {
  const commissioning = useService(Commissioning);
  const there = usePage((page) => page.online && isHardware(page));
  const asking = useRef(false);
  useTick(perSecond, () => {
    if (!there || asking.current) return;
    asking.current = true;
    commissioning
      .learn()
      .catch(() => undefined) // the connection's own state tells of it
      .finally(() => {
        asking.current = false;
      });
  });
}
