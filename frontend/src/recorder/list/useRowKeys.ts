import { useLayoutEffect, useRef, type FocusEvent, type KeyboardEvent } from "react";

const CONTROLS = "a, button, input";
const STEPS: Partial<Record<string, "previousElementSibling" | "nextElementSibling">> = {
  ArrowUp: "previousElementSibling",
  ArrowDown: "nextElementSibling",
};

/** For the body of a table: up and down go along its column, and Tab stops in one row only, the last that was used. */
export function useRowKeys() {
  const body = useRef<HTMLTableSectionElement>(null);
  const used = useRef<Element>(null);
  const mark = () => {
    const rows = [...(body.current?.rows ?? [])];
    const chosen = rows.find((row) => row === used.current) ?? rows.at(0);
    for (const row of rows)
      for (const control of row.querySelectorAll<HTMLElement>(CONTROLS))
        control.tabIndex = row === chosen ? 0 : -1;
  };
  useLayoutEffect(mark);
  return {
    ref: body,
    onFocus: ({ target }: FocusEvent) => {
      const row = target.closest("tr");
      if (!row || !body.current?.contains(row)) return; // in what a row opened
      used.current = row;
      mark();
    },
    onKeyDown: (event: KeyboardEvent) => {
      const step = STEPS[event.key];
      const cell = event.target instanceof Element ? event.target.closest("td") : null;
      if (!step || !cell) return;
      event.preventDefault();
      cell.parentElement?.[step]?.children
        .item(cell.cellIndex)
        ?.querySelector<HTMLElement>(CONTROLS)
        ?.focus();
    },
  };
}
