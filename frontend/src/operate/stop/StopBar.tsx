import { IconHandStop } from "@tabler/icons-react";
import { useEffect, useRef, type RefObject } from "react";
import { silenceOf, usePage } from "../../live/page";
import { useNarrow } from "../../ui/narrow";
import { useService } from "../../ui/services";
import { isLocked } from "../lock/lock";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { StatePill } from "../StatePill";
import { EmergencyStop } from "./stop";

/** A click this soon after the pointer came down was heard then. */
const CLICK_MS = 1000;

/** The rig's state and the E-STOP, at the edge of whatever is shown: a root of its own, over every dialog and frame. */
export function StopBar() {
  const bar = usePinned();
  const narrow = useNarrow();
  const locked = usePage(isLocked);
  return (
    <aside ref={bar} className="stop-bar" aria-label="State and E-STOP">
      <StatePill />
      {narrow || locked ? <Hold /> : null}
      <EStop />
      <News />
    </aside>
  );
}

/** Keep the bar where it is seen: two fingers that zoom, or a keyboard on the screen, move the page under its edge. */
function usePinned(): RefObject<HTMLElement | null> {
  const bar = useRef<HTMLElement>(null);
  useEffect(() => {
    const seen = window.visualViewport;
    const pin = () => {
      if (!seen || !bar.current) return;
      const { scale, offsetLeft, offsetTop, width } = seen;
      const right = offsetLeft + width - document.documentElement.clientWidth;
      const moved = scale > 1.001 || offsetTop > 0.5;
      bar.current.style.transform = moved ? `translate(${right}px, ${offsetTop}px) scale(${1 / scale})` : "";
    };
    pin();
    seen?.addEventListener("resize", pin);
    seen?.addEventListener("scroll", pin);
    return () => {
      seen?.removeEventListener("resize", pin);
      seen?.removeEventListener("scroll", pin);
    };
  }, []);
  return bar;
}

/** Works for everyone, in every state; never disabled. It acts when it is touched: a finger lifts 100 ms later. */
function EStop() {
  const stop = useService(EmergencyStop);
  const starting = usePage((page) => page.starting !== "");
  const meaning = usePage((page) => {
    const silent = silenceOf(page);
    if (silent === "none") return "Vent at once (Esc Esc)";
    if (page.session === "absent" && !page.online) return "Signed out: use the hardware stop as well";
    if (silent === "server") return "No connection to the server: use the hardware stop as well";
    const why = starting ? "The rig starts again" : "The rig does not answer";
    return `${why}: use the hardware stop as well`;
  });
  const touchedAt = useRef(-Infinity);
  return (
    <button
      type="button"
      className="e-stop"
      data-testid="e-stop"
      title={meaning}
      aria-label={`E-STOP. ${meaning}`}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        touchedAt.current = event.timeStamp;
        stop.press();
      }}
      onClick={(event) => {
        const heard = event.detail > 0 && event.timeStamp - touchedAt.current < CLICK_MS;
        if (!heard) stop.press(); // by key, or by a program that reads the screen
      }}
    >
      <IconHandStop size={20} aria-hidden />
      E-STOP
    </button>
  );
}

/** Where the panels stand one behind the other, or the page is locked, Hold is not among what may be hidden. */
function Hold() {
  const operations = useService(Operations);
  const reason = useWhyNot("hold");
  return (
    <button
      type="button"
      className="stop-hold"
      data-testid="stop-hold"
      title={reason ?? "Freeze the reference where it is (Esc)"}
      aria-disabled={reason !== null}
      onClick={() => operations.holdByKey()}
    >
      Hold
    </button>
  );
}

/** That the E-STOP arrived, or that no way is left. */
function News() {
  const news = usePage((page) => page.stop);
  return (
    <output className="stop-news" data-testid="stop-news" data-phase={news?.phase}>
      {news?.text}
    </output>
  );
}
