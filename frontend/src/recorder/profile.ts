import type { Profile } from "../api/types";
import type { Page } from "../live/page";
import { quietly, type PageStorage } from "../ui/storage";
import type { Store } from "../ui/store";

const KEY = "tendril-record-profile";

/** The profile of the last visit, and kept from now on. */
export function keepProfile(page: Store<Page>, storage: Pick<PageStorage, "getItem" | "setItem">): void {
  const last = quietly(() => storage.getItem(KEY));
  if (isProfile(last)) page.patch({ recordingProfile: last });
  let kept = page.get().recordingProfile;
  page.subscribe(() => {
    const { recordingProfile } = page.get();
    if (recordingProfile === kept) return;
    kept = recordingProfile;
    quietly(() => {
      storage.setItem(KEY, recordingProfile);
    });
  });
}

export function isProfile(value: unknown): value is Profile {
  return value === "standard" || value === "full";
}
