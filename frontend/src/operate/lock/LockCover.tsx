import { IconLock } from "@tabler/icons-react";
import { useEffect, useRef, useState, type ComponentType } from "react";
import { usePage } from "../../live/page";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { isLocked, slid, TouchLock, type Way } from "./lock";

const HOLD_MS = 1000;

interface Confirmation {
  readonly onDone: () => void;
}

/** Over the whole page while it is locked, but not over its edge with state, Hold and E-STOP: a root of its own. */
export function LockCover() {
  const locked = usePage(isLocked);
  return locked ? <Cover /> : null;
}

function Cover() {
  const lock = useService(TouchLock);
  const by = useStore(lock.choice, (choice) => choice.by);
  const panel = useRef<HTMLElement>(null);
  useEffect(() => {
    const focused = document.activeElement;
    const free = shut();
    panel.current?.focus();
    return () => {
      free();
      if (focused instanceof HTMLElement && focused.isConnected) focused.focus();
    };
  }, []);
  const Unlock = UNLOCK[by];
  return (
    <div className="lock" data-testid="lock">
      <section ref={panel} className="lock-panel" aria-label="The page is locked" tabIndex={-1}>
        <p role="status">
          <IconLock size={16} aria-hidden /> Locked: only E-STOP and Hold act
        </p>
        <Unlock onDone={() => lock.unlock()} />
      </section>
    </div>
  );
}

/** Take everything but the edge and the lock from keys and readers of screens, what opens later too; returns how it ends. */
function shut(): () => void {
  const others = () => [...document.body.children].filter(({ id }) => id !== "edge" && id !== "lock");
  const mark = (on: boolean) => {
    for (const other of others()) other.toggleAttribute("inert", on);
  };
  const root = document.documentElement;
  const seen = new MutationObserver(() => {
    mark(true);
  });
  mark(true);
  root.dataset.locked = "";
  seen.observe(document.body, { childList: true });
  return () => {
    seen.disconnect();
    delete root.dataset.locked;
    mark(false);
  };
}

/** A touch anywhere on its way does not take the thumb there; by keys, and for readers of screens, it goes in steps. */
function Slide({ onDone }: Confirmation) {
  const [at, setAt] = useState(0);
  const back = () => setAt(0);
  return (
    <label className="lock-slide">
      Slide to unlock
      <input
        type="range"
        min={0}
        max={100}
        step={5}
        value={at}
        data-testid="unlock"
        onChange={(event) => {
          const next = slid(at, Number(event.currentTarget.value));
          setAt(next);
          if (next === 100) onDone();
        }}
        onPointerUp={back}
        onPointerCancel={back}
        onBlur={back}
      />
    </label>
  );
}

function Hold({ onDone }: Confirmation) {
  const [held, setHeld] = useState(false);
  useEffect(() => {
    if (!held) return;
    const timer = setTimeout(onDone, HOLD_MS);
    return () => {
      clearTimeout(timer);
    };
  }, [held, onDone]);
  const press = () => setHeld(true);
  const lift = () => setHeld(false);
  return (
    <button
      type="button"
      className="lock-hold"
      data-held={held}
      data-testid="unlock"
      onPointerDown={press}
      onPointerUp={lift}
      onPointerLeave={lift}
      onPointerCancel={lift}
      onContextMenu={(event) => {
        event.preventDefault(); // what a long press asks for elsewhere
      }}
      onKeyDown={(event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        press();
      }}
      onKeyUp={lift}
      onBlur={lift}
      onClick={(event) => {
        if (event.detail === 0) onDone(); // neither pointer nor key: a program that reads the screen
      }}
    >
      Hold for 1 s to unlock
    </button>
  );
}

function TypeNumber({ onDone }: Confirmation) {
  const [wanted, setWanted] = useState(anyNumber);
  const [typed, setTyped] = useState("");
  return (
    <label className="lock-number">
      Type {wanted} to unlock
      <input
        inputMode="numeric"
        autoComplete="off"
        maxLength={2}
        value={typed}
        data-testid="unlock"
        data-wanted={wanted}
        onChange={({ currentTarget: { value } }) => {
          setTyped(value.length < 2 ? value : "");
          if (value === String(wanted)) onDone();
          else if (value.length >= 2) setWanted(anyNumber());
        }}
      />
    </label>
  );
}

function anyNumber(): number {
  return 10 + Math.floor(90 * Math.random());
}

const UNLOCK: Record<Way, ComponentType<Confirmation>> = { slide: Slide, hold: Hold, number: TypeNumber };
