import { useEffect } from "react";
import type { Dashboard } from "./dashboard";
import { focusOf, KeyMap, type Action } from "../operate/target/keys";
import { useDashboard } from "../ui/context";

const keyMap = new KeyMap();

const ESCAPE = {
  key: "Escape",
  shiftKey: false,
  ctrlKey: false,
  altKey: false,
  metaKey: false,
  repeat: false,
};

/** What the server puts into viser's and rerun's pages says so: they run in a process of their own, and tell of Esc, and
 * of a frame that moved under a press. */
function says(data: unknown, word: "escape" | "moved"): boolean {
  return typeof data === "object" && data !== null && "tendril" in data && data.tendril === word;
}

function perform(action: Action, dashboard: Dashboard): void {
  switch (action.kind) {
    case "hold":
      dashboard.operations.holdByKey();
      return;
    case "e_stop":
      dashboard.stop.press();
      return;
    case "follow":
      void dashboard.aim.follow();
      return;
    case "record":
      void dashboard.operations.toggleRecording();
      return;
    case "help":
      dashboard.page.patch({ help: !dashboard.page.get().help });
      return;
    case "nudge":
      dashboard.aim.nudge(action.dx, action.dy, action.fresh);
      return;
    case "release":
      dashboard.aim.release();
      return;
  }
}

/** The page's keys, heard before any focused control or dialog gets them. While signed out only Esc means something. */
export function useKeys(): void {
  const dashboard = useDashboard();
  useEffect(() => {
    const hear = (event: KeyboardEvent) => {
      const action = keyMap.press(event, focusOf(document.activeElement), performance.now());
      if (!action || (event.key !== "Escape" && dashboard.page.get().session !== "present")) return;
      if (action.kind === "nudge") event.preventDefault();
      perform(action, dashboard);
    };
    const hearFrame = (event: MessageEvent<unknown>) => {
      if (event.origin !== window.location.origin) return;
      if (says(event.data, "moved")) dashboard.aim.abortGizmo();
      if (!says(event.data, "escape")) return;
      const action = keyMap.press(ESCAPE, "widget", performance.now());
      if (action) perform(action, dashboard);
    };
    const letGo = (action: Action | null) => {
      if (action) perform(action, dashboard);
    };
    const stop = new AbortController();
    const { signal } = stop;
    window.addEventListener("keydown", hear, { capture: true, signal });
    window.addEventListener("keyup", (event) => { letGo(keyMap.lift(event.key)); }, { capture: true, signal }); // prettier-ignore
    window.addEventListener("blur", () => { letGo(keyMap.liftAll()); }, { signal }); // prettier-ignore
    window.addEventListener("message", hearFrame, { signal });
    return () => {
      stop.abort();
    };
  }, [dashboard]);
}
