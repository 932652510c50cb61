import { useEffect, useEffectEvent } from "react";
import { useDashboard } from "./context";

/** Do `action`, as the last render gave it, `rate` times a second. */
export function useTick(rate: number, action: () => void): void {
  const { ticker } = useDashboard();
  const tick = useEffectEvent(action);
  useEffect(
    () =>
      ticker.every(rate, "number", () => {
        tick();
      }),
    [ticker, rate],
  );
}
