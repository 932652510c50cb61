import { useEffect, type KeyboardEvent, type PointerEvent } from "react";
import { useWhyNot } from "../../operate/permission";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { Commissioning } from "./commissioning";
import type { Chamber } from "./steps";

/** A button that fills a chamber while it is held, by pointer, finger or Space; whatever ends the hold lets go. */
export function JogButton({ chamber }: { readonly chamber: Chamber }) {
  const { jog, store } = useService(Commissioning);
  const held = useStore(store, (seen) => seen.held === chamber);
  const reason = useWhyNot("settings");
  const release = () => {
    jog.release(chamber);
  };
  useEffect(() => {
    if (reason !== null) jog.release(chamber);
    return () => {
      jog.release(chamber);
    };
  }, [jog, chamber, reason]);
  useEffect(() => {
    if (!held) return;
    const letGo = () => {
      jog.release();
    };
    window.addEventListener("blur", letGo);
    window.addEventListener("pagehide", letGo);
    document.addEventListener("visibilitychange", letGo);
    return () => {
      window.removeEventListener("blur", letGo);
      window.removeEventListener("pagehide", letGo);
      document.removeEventListener("visibilitychange", letGo);
    };
  }, [jog, held]);
  const press = () => {
    if (reason === null) jog.press(chamber);
  };
  const down = (event: PointerEvent<HTMLButtonElement>) => {
    if (event.button !== 0 || !event.isPrimary) return;
    // A finger is captured by what it touched first: it would then never be seen to leave
    if (event.currentTarget.hasPointerCapture(event.pointerId))
      event.currentTarget.releasePointerCapture(event.pointerId);
    press();
  };
  const key = (event: KeyboardEvent<HTMLButtonElement>) => {
    if (event.key !== " ") return;
    event.preventDefault();
    if (!event.repeat) press();
  };
  return (
    <button
      type="button"
      className="jog-button"
      aria-label={`Hold to fill ${chamber}`}
      aria-pressed={held}
      aria-disabled={reason !== null}
      title={reason ?? `Fills ${chamber} while it is held`}
      data-testid={`jog-${chamber}`}
      onPointerDown={down}
      onPointerUp={release}
      onPointerCancel={release}
      onPointerLeave={release}
      onKeyDown={key}
      onKeyUp={(event) => {
        if (event.key === " ") release();
      }}
      onBlur={release}
      onContextMenu={(event) => {
        event.preventDefault();
      }}
    >
      {held ? "Filling" : "Fill"} {chamber}
    </button>
  );
}
