/** What was, is and would be again: undo and redo of immutable values. */
export interface History<T> {
  readonly past: readonly T[];
  readonly present: T;
  readonly future: readonly T[];
}

const KEPT = 100;

export function begun<T>(present: T): History<T> {
  return { past: [], present, future: [] };
}

/** `next` is the present now; what had been undone is forgotten. */
export function recorded<T>({ past, present }: History<T>, next: T): History<T> {
  return { past: [...past, present].slice(-KEPT), present: next, future: [] };
}

export function undone<T>(history: History<T>): History<T> {
  const { past, present, future } = history;
  const last = past.at(-1);
  return last === undefined
    ? history
    : { past: past.slice(0, -1), present: last, future: [present, ...future] };
}

export function redone<T>(history: History<T>): History<T> {
  const { past, present, future } = history;
  const next = future.at(0);
  return next === undefined ? history : { past: [...past, present], present: next, future: future.slice(1) };
}
