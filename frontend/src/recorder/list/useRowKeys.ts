import type { KeyboardEvent } from "react";
import { useTabStop } from "../../ui/buttons/tabStop";

const CONTROLS = "a, button, input";
const STEPS: Partial<Record<string, "previousElementSibling" | "nextElementSibling">> = {
  ArrowUp: "previousElementSibling",
  ArrowDown: "nextElementSibling",
};

/** For the body of a table: up and down go along its column, and Tab stops in one row only, the last that was used. */
export function useRowKeys() {
  const stop = useTabStop(
    (body: HTMLTableSectionElement) => [...body.rows],
    (row) => row.querySelectorAll<HTMLElement>(CONTROLS),
  );
  return {
    ...stop,
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
