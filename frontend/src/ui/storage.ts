/** Where a browser keeps texts; each call may throw where it keeps none, or has no room. */
export type PageStorage = Pick<Storage, "getItem" | "setItem" | "removeItem">;

/** A browser that keeps nothing is no trouble: what it should keep lasts as long as the page. */
export function quietly<T>(action: () => T): T | null {
  try {
    return action();
  } catch {
    return null;
  }
}
