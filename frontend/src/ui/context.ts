import { createContext, use } from "react";
import type { Dashboard } from "../app/dashboard";
import type { Page } from "../live/page";
import { situation } from "../live/page";
import { whyNot, type Control } from "../operate/permission";
import { useStore } from "./store";

export const DashboardContext = createContext<Dashboard | null>(null);

export function useDashboard(): Dashboard {
  const dashboard = use(DashboardContext);
  if (!dashboard) throw new Error("no dashboard around this component");
  return dashboard;
}

/** Follow a part of the page's state; `select` gives a primitive or an object that is kept. */
export function usePage<S>(select: (page: Page) => S): S {
  return useStore(useDashboard().page, select);
}

/** Why `control` does not work now; null when it does. */
export function useWhyNot(control: Control): string | null {
  return usePage((page) => whyNot(control, situation(page)));
}
