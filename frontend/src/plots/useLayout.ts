import { useEffect, useState } from "react";
import { api, named, dataOf } from "../api/rest";
import type { PlotLayout } from "../api/types";
import { Operations } from "../operate/operations";
import { useService } from "../ui/services";
import { DEFAULT_LAYOUT, LAST_USED, layoutName } from "./layout";

const SAVE_AFTER_MS = 800;

export interface Layouts {
  /** What is plotted; null until the server said what this browser plotted last. */
  readonly layout: PlotLayout | null;
  /** Names of the layouts saved on purpose. */
  readonly names: readonly string[];
  readonly change: (change: (layout: PlotLayout) => PlotLayout) => void;
  readonly open: (name: string) => Promise<void>;
  readonly save: (name: string) => Promise<void>;
  readonly forget: (name: string) => Promise<void>;
}

const savedNames = () => dataOf(api.GET("/api/layouts"));
const layoutOf = (name: string) => dataOf(api.GET("/api/layouts/{name}", named(name)));
const keepLayout = (name: string, body: PlotLayout) =>
  api.PUT("/api/layouts/{name}", { ...named(name), body });

/** Names of the saved layouts, and the one that was used last; the default one where the server does not say. */
async function remembered(): Promise<[string[], PlotLayout]> {
  try {
    const names = await savedNames();
    const last = names.includes(LAST_USED) ? await layoutOf(LAST_USED) : DEFAULT_LAYOUT;
    return [names.filter((name) => name !== LAST_USED), last];
  } catch {
    return [[], DEFAULT_LAYOUT];
  }
}

/** The layout in use and those kept on the server for this browser. What is in use is kept by itself. */
export function useLayout(): Layouts {
  const operations = useService(Operations);
  const [layout, setLayout] = useState<PlotLayout | null>(null);
  const [kept, setKept] = useState<PlotLayout | null>(null);
  const [names, setNames] = useState<readonly string[]>([]);
  useEffect(() => {
    void remembered().then(([known, last]) => {
      setNames(known);
      setLayout(last);
      setKept(last);
    });
  }, []);
  useEffect(() => {
    if (layout === null || layout === kept) return;
    const timer = setTimeout(() => {
      // Where that fails the next change tries again; no one needs to be told.
      keepLayout(LAST_USED, layout).then(
        () => { setKept(layout); }, // prettier-ignore
        () => undefined,
      );
    }, SAVE_AFTER_MS);
    return () => {
      clearTimeout(timer);
    };
  }, [layout, kept]);
  const relist = async () => {
    const known = await savedNames();
    setNames(known.filter((name) => name !== LAST_USED));
  };
  return {
    layout,
    names,
    change: (change) => setLayout((old) => (old === null ? null : change(old))),
    open: (name) =>
      operations.attempt("Layout not opened", async () => {
        setLayout(await layoutOf(name));
      }),
    save: (name) =>
      operations.attempt("Layout not saved", async () => {
        if (layout !== null) await keepLayout(layoutName(name), layout);
        await relist();
      }),
    forget: (name) =>
      operations.attempt("Layout not deleted", async () => {
        await api.DELETE("/api/layouts/{name}", named(name));
        await relist();
      }),
  };
}
