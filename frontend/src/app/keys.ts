import { Drawing } from "../drawing/drawing";
import { PageStore } from "../live/page";
import { isLocked, TouchLock } from "../operate/lock/lock";
import { Operations } from "../operate/operations";
import { openOverlays, pressEscape, type EscapePort } from "../operate/stop/escape";
import { EmergencyStop } from "../operate/stop/stop";
import { TargetControl } from "../operate/target/targetControl";
import { TwinTime } from "../operate/time/twinTime";
import { focusOf, KeyMap, type Action, type Press } from "../operate/target/keys";
import { Recorder } from "../recorder/recorder";
import { focusWhenThere } from "../ui/focus";
import type { Services } from "../ui/services";

const ESCAPE: Press = {
  key: "Escape",
  shiftKey: false,
  ctrlKey: false,
  altKey: false,
  metaKey: false,
  repeat: false,
};

/** What the server puts into viser's and rerun's pages says so: they run in a process of their own, and tell of Esc, of
 * touches, and of a frame that moved under a press. */
function says(data: unknown, word: "escape" | "moved" | "touched"): boolean {
  return typeof data === "object" && data !== null && "tendril" in data && data.tendril === word;
}

function perform(action: Action, services: Services): void {
  const [targetControl, page] = [services.get(TargetControl), services.get(PageStore)];
  switch (action.kind) {
    case "hold":
      services.get(Operations).holdByKey();
      return;
    case "e_stop":
      services.get(EmergencyStop).press();
      return;
    case "follow":
      void targetControl.follow();
      return;
    case "record":
      void services.get(Recorder).toggle();
      return;
    case "mark":
      void services.get(Recorder).mark();
      return;
    case "pause":
      void services.get(TwinTime).toggle();
      return;
    case "step":
      void services.get(TwinTime).step();
      return;
    case "help":
      page.patch({ help: !page.get().help });
      return;
    case "view":
      goToView(page, page.get().view === "live" ? "review" : "live");
      return;
    case "panel":
      goToPanel(page, action.place);
      return;
    case "nudge":
      if (!services.get(Drawing).nudge(action.dx, action.dy))
        targetControl.nudge(action.dx, action.dy, action.fresh);
      return;
    case "release":
      services.get(Drawing).settle();
      targetControl.release();
      return;
  }
}

function goToView(page: PageStore, view: "live" | "review"): void {
  if (inDialog()) return;
  page.patch({ view });
  focusWhenThere(view === "live" ? ".tabs [aria-selected=true]" : ".review [data-focus-home]");
}

/** Choose the panel's tab, and go there. */
function goToPanel(page: PageStore, place: number): void {
  const tab = document.querySelectorAll<HTMLElement>(".tabs [role=tab]").item(place - 1);
  if (!(tab instanceof HTMLElement) || inDialog()) return;
  page.patch({ view: "live" });
  tab.click();
  focusWhenThere(".tabs [aria-selected=true]");
}

/** A dialog keeps the focus. */
function inDialog(): boolean {
  return document.querySelector("[aria-modal=true]") !== null;
}

/** What an Esc may close; nothing behind the cover of a locked page. */
function escapePort(services: Services): EscapePort {
  const [drawing, page] = [services.get(Drawing), services.get(PageStore)];
  return {
    layers: () => {
      if (isLocked(page.get())) return [];
      return [...(drawing.isOpen() ? [drawing] : []), ...openOverlays()];
    },
    later: (action) => setTimeout(action),
  };
}

/** The page's keys, heard before any focused control or dialog gets them. While signed out, or locked, only Esc means something. */
export function hearKeys(services: Services): void {
  const keyMap = new KeyMap();
  const act = (action: Action | null) => {
    if (action) perform(action, services);
  };
  const escapes = escapePort(services);
  const hearEscape = (press: Press) => {
    const now = performance.now();
    if (!press.repeat) pressEscape(escapes, () => act(keyMap.press(press, "widget", now)));
  };
  const hear = (event: KeyboardEvent) => {
    if (event.key === "Escape") {
      if (event.isTrusted && !event.isComposing) hearEscape(event);
      return;
    }
    const action = keyMap.press(event, focusOf(document.activeElement), performance.now());
    const page = services.get(PageStore).get();
    if (page.session !== "present" || isLocked(page)) return;
    if (action?.kind === "nudge" && page.view === "review") return; // the target is not in sight: arrows scroll
    if (action?.kind === "nudge" || action?.kind === "mark") event.preventDefault(); // the letter is no part of the label
    act(action);
  };
  const hearFrame = (event: MessageEvent<unknown>) => {
    if (event.origin !== window.location.origin) return;
    if (says(event.data, "touched")) services.get(TouchLock).touched();
    if (says(event.data, "moved")) services.get(TargetControl).abortGizmo();
    if (says(event.data, "escape")) hearEscape(ESCAPE);
  };
  window.addEventListener("keydown", hear, { capture: true });
  window.addEventListener("keyup", (event) => act(keyMap.lift(event.key)), { capture: true }); // prettier-ignore
  window.addEventListener("blur", () => act(keyMap.liftAll())); // prettier-ignore
  window.addEventListener("message", hearFrame);
}
