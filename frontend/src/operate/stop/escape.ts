/** Something that lies open, and that an Esc may close. */
export interface Layer {
  isOpen(): boolean;
  /** It gets the Esc that it did not hear, as the focus was elsewhere. */
  hear?(): void;
}

/** What an Esc needs from outside, so that tests can open layers and hold the clock. */
export interface EscapePort {
  /** What lies open now, the topmost last. */
  layers(): readonly Layer[];
  /** Once everything that listens has handled the key. */
  later(action: () => void): void;
}

/**
 * An Esc that closes a layer is that layer's alone; any other is for the rig, and `stop` is called.
 *
 * What counts is that something was closed, not that something lay open. On the bare page nothing is waited for.
 */
export function pressEscape(port: EscapePort, stop: () => void): void {
  const layers = port.layers();
  const closed = () => layers.some((layer) => !layer.isOpen());
  if (layers.length === 0) {
    stop();
    return;
  }
  port.later(() => {
    if (closed()) return;
    layers.at(-1)?.hear?.();
    port.later(() => {
      if (!closed()) stop();
    });
  });
}

/**
 * What lies over the page until Esc or a press elsewhere closes it: dialogs, popovers, menus, lists to choose from.
 *
 * A tooltip is none of them: nobody opened it, it stands wherever the pointer rests. It would take the first of two Esc
 * from everyone who has just pressed Run. Nor is the guide, whose steps come and go by themselves.
 */
const OVERLAYS = "[role=dialog], [role=alertdialog], [role=menu], [role=listbox]";

/** The layers that lie over the page now, the topmost last; the window's own, fullscreen, closes before all. */
export function openOverlays(): readonly Layer[] {
  const overlays = [...document.querySelectorAll(OVERLAYS)].filter(isShown).map(overlay);
  const field = document.activeElement;
  const search = field instanceof HTMLInputElement && field.type === "search" && field.value !== "";
  return [
    ...(search ? [{ isOpen: () => field.value !== "" }] : []), // browsers clear it
    ...overlays,
    ...(document.fullscreenElement ? [{ isOpen: () => false }] : []), // browsers leave it, later
  ];
}

function overlay(element: Element): Layer {
  return {
    isOpen: () => isShown(element),
    hear: () => void element.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape" })),
  };
}

function isShown(element: Element): boolean {
  return element.isConnected && element.checkVisibility({ visibilityProperty: true });
}
