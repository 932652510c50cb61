import { useState } from "react";

/** What a number field holds while it is typed in: Mantine hands over "0.10", "2." and "05" as text. */
export type Typed = number | string;

/** The number that was typed, null where there is none yet. */
export function typedNumber(typed: Typed): number | null {
  const value = typeof typed === "string" && typed.trim() === "" ? NaN : Number(typed);
  return Number.isFinite(value) ? value : null;
}

/** What is being typed, null while nothing is. */
export function useTyped() {
  const [typed, setTyped] = useState<Typed | null>(null);
  /** Show the value in force again, unless another number was typed since this was rendered. */
  const drop = () => setTyped((now) => (isSame(now, typed) ? null : now));
  return { typed, setTyped, drop };
}

function isSame(a: Typed | null, b: Typed | null): boolean {
  return typedNumber(a ?? "") === typedNumber(b ?? "");
}
