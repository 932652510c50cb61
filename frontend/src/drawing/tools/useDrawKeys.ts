import { useWindowEvent } from "@mantine/hooks";
import { usePage } from "../../live/page";
import { focusOf, type Focus } from "../../operate/target/keys";
import { useService } from "../../ui/services";
import { Drawing } from "../drawing";

/** The keys of the drawing, while it is in sight. An Esc that drops a line is no stop (operate/stop/escape.ts). */
export function useDrawKeys(): void {
  const drawing = useService(Drawing);
  const shown = usePage((page) => page.view === "live");
  const hear = (event: KeyboardEvent) => {
    if (shown && press(event, drawing)) event.preventDefault();
  };
  useWindowEvent("keydown", hear, { capture: true });
}

/** True if the key was the drawing's alone. */
function press(event: KeyboardEvent, drawing: Drawing): boolean {
  const focus = focusOf(document.activeElement);
  if (event.key === "Escape") drawing.abandon();
  if (focus === "text" || event.key === "Escape") return false;
  if (event.ctrlKey || event.metaKey) return withControl(event, focus, drawing);
  if (focus !== "page") return false;
  if (event.key === "Delete" || event.key === "Backspace") drawing.remove();
  else if (event.key === "Enter") drawing.finishStroke();
  else return false;
  return true;
}

/** The same with Ctrl, or Cmd on a Mac. Elsewhere than on the plan, Ctrl A is the browser's. */
function withControl(event: KeyboardEvent, focus: Focus, drawing: Drawing): boolean {
  const key = event.key.toLowerCase();
  const isOnPlan = document.activeElement?.hasAttribute("data-plan") ?? false;
  if (key === "z" && !event.shiftKey) drawing.undo();
  else if (key === "y" || key === "z") drawing.redo();
  else if (key === "a" && isOnPlan) drawing.selectAll();
  else if (key === "g" && focus === "page") drawing.group(!event.shiftKey);
  else return false;
  return true;
}
