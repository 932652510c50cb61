import { quietly, type PageStorage } from "../ui/storage";
import { useService } from "../ui/services";
import { Store, useStore } from "../ui/store";

/** What of the plan may be switched off; target and reference are what an operator moves, and stay. */
export const LAYERS = ["path", "predicted", "measured", "observer", "reach", "twin"] as const;
export type Layer = (typeof LAYERS)[number];
export type Hidden = ReadonlySet<Layer>;

const KEY = "tendril-plan-hidden";

/** Which layers of the plan are hidden; kept from visit to visit. */
export class Layers {
  readonly store: Store<{ hidden: Hidden }>;

  constructor(private readonly storage: Pick<PageStorage, "getItem" | "setItem">) {
    const kept = quietly(() => storage.getItem(KEY))?.split(" ") ?? [];
    this.store = new Store<{ hidden: Hidden }>({
      hidden: new Set(LAYERS.filter((layer) => kept.includes(layer))),
    });
  }

  /** Hide what is shown, show what is hidden. */
  toggle(layer: Layer): void {
    const { hidden } = this.store.get();
    const next = new Set(LAYERS.filter((one) => hidden.has(one) !== (one === layer)));
    this.store.patch({ hidden: next });
    quietly(() => {
      this.storage.setItem(KEY, [...next].join(" "));
    });
  }
}

export function useHidden(): Hidden {
  return useStore(useService(Layers).store, ({ hidden }) => hidden);
}
