import type { Profile } from "../api/types";
import type { Page } from "../live/page";
import { quietly, type Shelf } from "../ui/shelf";
import type { Store } from "../ui/store";

const KEY = "tendril-record-profile";

/** The profile of the last visit, and kept from now on. */
export function keepProfile(page: Store<Page>, shelf: Pick<Shelf, "getItem" | "setItem">): void {
  const last = quietly(() => shelf.getItem(KEY));
  if (isProfile(last)) page.patch({ recordingProfile: last });
  let kept = page.get().recordingProfile;
  page.subscribe(() => {
    const { recordingProfile } = page.get();
    if (recordingProfile === kept) return;
    kept = recordingProfile;
    quietly(() => {
      shelf.setItem(KEY, recordingProfile);
    });
  });
}

export function isProfile(value: unknown): value is Profile {
  return value === "standard" || value === "full";
}
