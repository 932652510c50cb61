import { useEffect, useState } from "react";
import type { Dashboard } from "../state/dashboard";
import { focusOf, KeyMap, type Action } from "../state/keys";
import { useDashboard } from "./context";

const keyMap = new KeyMap();

const ESCAPE = {
  key: "Escape",
  shiftKey: false,
  ctrlKey: false,
  altKey: false,
  metaKey: false,
  repeat: false,
};

/** What the server puts into viser's and rerun's pages: they run in a process of their own, and tell of Esc. */
function isEscape(data: unknown): boolean {
  return typeof data === "object" && data !== null && "tendril" in data && data.tendril === "escape";
}

function perform(action: Action, dashboard: Dashboard, help: () => void): void {
  switch (action.kind) {
    case "hold":
      dashboard.operations.holdByKey();
      return;
    case "e_stop":
      void dashboard.operations.emergencyStop();
      return;
    case "follow":
      void dashboard.aim.follow();
      return;
    case "record":
      void dashboard.operations.toggleRecording();
      return;
    case "help":
      help();
      return;
    case "nudge":
      dashboard.aim.nudge(action.dx, action.dy, action.fresh);
      return;
    case "release":
      dashboard.aim.release();
      return;
  }
}

/** The page's keys, heard before any focused control gets them; returns whether the list of keys is open. */
export function useKeys(): readonly [boolean, (open: boolean) => void] {
  const dashboard = useDashboard();
  const [help, setHelp] = useState(false);
  useEffect(() => {
    const hear = (event: KeyboardEvent) => {
      const action = keyMap.press(event, focusOf(document.activeElement), performance.now());
      if (!action) return;
      if (action.kind === "nudge") event.preventDefault();
      perform(action, dashboard, () => {
        setHelp((open) => !open);
      });
    };
    const hearFrame = (event: MessageEvent<unknown>) => {
      if (event.origin !== window.location.origin || !isEscape(event.data)) return;
      const action = keyMap.press(ESCAPE, "widget", performance.now());
      if (action) perform(action, dashboard, () => undefined);
    };
    const letGo = (action: Action | null) => {
      if (action) perform(action, dashboard, () => undefined);
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
  return [help, setHelp];
}
