import { useEffect, useState } from "react";

/** After the quick look stands: whoever leafs through recordings starts none, and its first cursor does not wait [ms]. */
const CALM_MS = 500;
/** How long a viewer that nobody looks at is kept [ms]. */
const KEPT_MS = 120_000;

/** Whether a viewer is to be there: while it is `shown`, and hidden for a while before, once the quick look is `drawn`, and after. */
export function useWarm(drawn: boolean, shown: boolean): boolean {
  const [warm, setWarm] = useState(false);
  useEffect(() => {
    if (!drawn && !shown) return;
    const start = setTimeout(setWarm, shown ? 0 : CALM_MS, true);
    const end = shown ? undefined : setTimeout(setWarm, KEPT_MS, false);
    return () => {
      clearTimeout(start);
      clearTimeout(end);
    };
  }, [drawn, shown]);
  return warm || shown;
}
