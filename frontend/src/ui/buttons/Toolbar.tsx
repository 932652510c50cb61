import type { KeyboardEvent, ReactNode } from "react";
import { useTabStop } from "./tabStop";

interface Props {
  readonly label: string;
  readonly className: string;
  readonly children: ReactNode;
}

/** Buttons of which Tab stops at one, the last that was used; arrows, Home and End go along them (WAI-ARIA: toolbar). */
export function Toolbar({ label, className, children }: Props) {
  const stop = useTabStop(buttonsIn, (button) => [button]);
  return (
    <div
      {...stop}
      className={className}
      role="toolbar"
      aria-label={label}
      onKeyDown={(event) => {
        const all = buttonsIn(event.currentTarget);
        const at = all.findIndex((button) => button === event.target);
        if (at >= 0) wentTo(event, at, all)?.focus();
      }}
    >
      {children}
    </div>
  );
}

function buttonsIn(bar: HTMLDivElement): readonly HTMLElement[] {
  return [...bar.querySelectorAll("button")];
}

/** To which of `all` the key goes from the one `at`. */
function wentTo(event: KeyboardEvent, at: number, all: readonly HTMLElement[]): HTMLElement | undefined {
  const places: Partial<Record<string, number>> = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: -1 };
  const place = places[event.key];
  if (place === undefined) return undefined;
  event.preventDefault();
  return all.at(place % all.length);
}
