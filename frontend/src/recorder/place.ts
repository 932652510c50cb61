import type { Page } from "../live/page";
import type { Store } from "../ui/store";

/** What of the page its address tells: `#review`, `#review/ID`, `#review/compare/ID1,ID2`; `#wall` for the large numbers; nothing for Live. */
export type Place = Pick<Page, "view" | "reviewed" | "compared">;

export const COMPARED_MAX = 4;

export function placeOf(hash: string): Place {
  const [view, first = "", second = ""] = hash.replace(/^#/, "").split("/").map(decoded);
  if (view === "wall") return { view, reviewed: null, compared: [] };
  if (view !== "review") return { view: "live", reviewed: null, compared: [] };
  if (first !== "compare") return { view, reviewed: first || null, compared: [] };
  const compared = [...new Set(second.split(","))].filter((id) => id !== "").slice(0, COMPARED_MAX);
  return { view, reviewed: null, compared };
}

export function hashOf({ view, reviewed, compared }: Place): string {
  if (view === "live") return "";
  if (view === "wall") return "#wall";
  if (compared.length > 0) return `#review/compare/${compared.map(encodeURIComponent).join(",")}`;
  return reviewed === null ? "#review" : `#review/${encodeURIComponent(reviewed)}`;
}

/** Keep page and address the same: a link opens its view, back and forward work, a reload stays. */
export function followAddress(page: Store<Page>): void {
  let known = window.location.hash;
  const arrive = () => {
    known = window.location.hash;
    const place = placeOf(known);
    if (hashOf(place) !== hashOf(page.get())) page.patch(place);
  };
  arrive();
  window.addEventListener("popstate", arrive);
  page.subscribe(() => {
    const hash = hashOf(page.get());
    if (hash === hashOf(placeOf(known))) return;
    known = hash;
    const { pathname, search } = window.location;
    window.history.pushState(null, "", pathname + search + hash);
  });
}

function decoded(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}
