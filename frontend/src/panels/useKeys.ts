import { useCallback, useEffect, useState } from "react";
import type { Dashboard } from "../state/dashboard";
import { focusOf, KeyMap, type Action } from "../state/keys";
import { useDashboard } from "./context";

const keyMap = new KeyMap();

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
    window.addEventListener("keydown", hear, { capture: true });
    return () => {
      window.removeEventListener("keydown", hear, { capture: true });
    };
  }, [dashboard]);
  return [help, setHelp];
}

/** Esc works inside a frame of our own origin too; its other keys are its own. */
export function useKeysInFrame(): (frame: HTMLIFrameElement) => void {
  const dashboard = useDashboard();
  return useCallback(
    (frame) => {
      frame.contentWindow?.addEventListener(
        "keydown",
        (event) => {
          const action = keyMap.press(event, "text", performance.now());
          if (action) perform(action, dashboard, () => undefined);
        },
        { capture: true },
      );
    },
    [dashboard],
  );
}
