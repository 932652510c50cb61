import { useLayoutEffect, useRef, type KeyboardEvent, type ReactNode } from "react";

interface Props {
  readonly label: string;
  readonly className: string;
  readonly children: ReactNode;
}

/** Buttons of which Tab stops at one, the last that was used; arrows, Home and End go along them (WAI-ARIA: toolbar). */
export function Toolbar({ label, className, children }: Props) {
  const bar = useRef<HTMLDivElement>(null);
  const stop = useRef<Element>(null);
  const buttons = () => [...(bar.current?.querySelectorAll("button") ?? [])];
  const mark = () => {
    const all = buttons();
    const chosen = all.find((button) => button === stop.current) ?? all.at(0);
    for (const button of all) button.tabIndex = button === chosen ? 0 : -1;
  };
  useLayoutEffect(mark);
  return (
    <div
      ref={bar}
      className={className}
      role="toolbar"
      aria-label={label}
      onKeyDown={(event) => {
        const all = buttons();
        const at = all.findIndex((button) => button === event.target);
        if (at >= 0) wentTo(event, at, all)?.focus();
      }}
      onFocus={({ target }) => {
        if (!bar.current?.contains(target)) return; // in what a button opened
        stop.current = target;
        mark();
      }}
    >
      {children}
    </div>
  );
}

/** To which of `all` the key goes from the one `at`. */
function wentTo(event: KeyboardEvent, at: number, all: readonly HTMLElement[]): HTMLElement | undefined {
  const places: Partial<Record<string, number>> = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: -1 };
  const place = places[event.key];
  if (place === undefined) return undefined;
  event.preventDefault();
  return all.at(place % all.length);
}
