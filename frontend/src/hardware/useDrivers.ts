import { useRef, useState } from "react";
import { usePage } from "../live/page";
import { textOf } from "../ui/format";
import { useTick } from "../ui/ticker";
import { readDrivers, type DriverStatus } from "./drivers";

const REFRESH_HZ = 2;

/** The newest looks at the drivers, and why there is none. */
export interface DriversSeen {
  readonly drivers: readonly DriverStatus[];
  readonly problem: string;
}

/** Looks at the drivers while who asks is shown; the browser draws no frames of a page that is not in sight. */
export function useDrivers(refreshHz = REFRESH_HZ): DriversSeen {
  const [seen, setSeen] = useState<DriversSeen>({ drivers: [], problem: "" });
  const shown = usePage((page) => page.online && page.view === "live");
  const asking = useRef(false);
  useTick(refreshHz, () => {
    if (!shown || asking.current) return;
    asking.current = true;
    readDrivers()
      .then(
        (drivers) => {
          setSeen({ drivers, problem: "" });
        },
        (error: unknown) => {
          setSeen((before) => ({ ...before, problem: textOf(error) }));
        },
      )
      .finally(() => {
        asking.current = false;
      });
  });
  return seen;
}
