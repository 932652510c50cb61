import { useEffect } from "react";
import type { Dashboard } from "../../app/dashboard";
import { focusOf } from "../../operate/target/keys";
import { useDashboard } from "../../ui/context";

/** The keys of the drawing; Esc also holds the rig, as everywhere. */
export function useDrawKeys(): void {
  const dashboard = useDashboard();
  useEffect(() => {
    const hear = (event: KeyboardEvent) => {
      if (press(event, dashboard)) event.preventDefault();
    };
    window.addEventListener("keydown", hear, { capture: true });
    return () => {
      window.removeEventListener("keydown", hear, { capture: true });
    };
  }, [dashboard]);
}

/** True if the key was the drawing's alone. */
function press(event: KeyboardEvent, { drawing }: Dashboard): boolean {
  const focus = focusOf(document.activeElement);
  if (event.key === "Escape") drawing.abandon();
  if (focus === "text" || event.key === "Escape") return false;
  if (event.ctrlKey || event.metaKey) return history(event, () => { drawing.undo(); }, () => { drawing.redo(); }); // prettier-ignore
  if (focus !== "page") return false;
  if (event.key === "Delete" || event.key === "Backspace") drawing.remove();
  else if (event.key === "Enter") drawing.finishStroke();
  else return false;
  return true;
}

function history(event: KeyboardEvent, undo: () => void, redo: () => void): boolean {
  const key = event.key.toLowerCase();
  if (key === "z" && !event.shiftKey) undo();
  else if (key === "y" || key === "z") redo();
  else return false;
  return true;
}
