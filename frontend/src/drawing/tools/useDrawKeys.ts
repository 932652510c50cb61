import { useEffect } from "react";
import { focusOf } from "../../operate/target/keys";
import { useService } from "../../ui/services";
import { Drawing } from "../drawing";

/** The keys of the drawing; Esc also holds the rig, as everywhere. */
export function useDrawKeys(): void {
  const drawing = useService(Drawing);
  useEffect(() => {
    const hear = (event: KeyboardEvent) => {
      if (press(event, drawing)) event.preventDefault();
    };
    window.addEventListener("keydown", hear, { capture: true });
    return () => {
      window.removeEventListener("keydown", hear, { capture: true });
    };
  }, [drawing]);
}

/** True if the key was the drawing's alone. */
function press(event: KeyboardEvent, drawing: Drawing): boolean {
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
