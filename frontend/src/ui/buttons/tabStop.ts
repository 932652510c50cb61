import { useLayoutEffect, useRef, type FocusEvent } from "react";

/** Of what `stops` finds in a place, Tab enters one only, the last that was used; `controls` are what it holds. */
export function useTabStop<Place extends HTMLElement>(
  stops: (place: Place) => readonly HTMLElement[],
  controls: (stop: HTMLElement) => Iterable<HTMLElement>,
) {
  const place = useRef<Place>(null);
  const used = useRef<Element>(null);
  const mark = () => {
    const all = place.current ? stops(place.current) : [];
    const chosen = all.find((stop) => stop === used.current) ?? all.at(0);
    for (const stop of all) for (const control of controls(stop)) control.tabIndex = stop === chosen ? 0 : -1;
  };
  useLayoutEffect(mark);
  const onFocus = ({ target }: FocusEvent) => {
    if (!place.current?.contains(target)) return; // in what one of them opened
    used.current = stops(place.current).find((stop) => stop.contains(target)) ?? used.current;
    mark();
  };
  return { ref: place, onFocus };
}
