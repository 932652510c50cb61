import { useSyncExternalStore } from "react";

/** Where plan, panels and plots do not fit side by side: phones, and what a zoom of 200 % leaves of a screen. */
const NARROW = "(max-width: 760px), (max-height: 560px), ((max-width: 960px) and (max-height: 900px))";
const narrow = window.matchMedia(NARROW);

/** Whether one panel at a time is shown; styles ask for `[data-layout="narrow"]`. */
export function useNarrow(): boolean {
  return useSyncExternalStore(subscribe, () => narrow.matches);
}

/** Mark the document now and at every change, before anything is painted for it. */
export function markLayout(): void {
  const mark = () => {
    document.documentElement.dataset.layout = narrow.matches ? "narrow" : "wide";
  };
  mark();
  narrow.addEventListener("change", mark);
}

function subscribe(listener: () => void): () => void {
  narrow.addEventListener("change", listener);
  return () => {
    narrow.removeEventListener("change", listener);
  };
}
