import { expect, test } from "vitest";
import { EMPTY_PAGE, type Page } from "../../live/page";
import { Store } from "../../ui/store";
import { isLocked, slid, TouchLock } from "./lock";

/** A signed-in page on a screen that is touched, its clock set by hand, in a browser that kept `kept`. */
function tablet(kept: object | string | null = null) {
  const page = new Store<Page>({ ...EMPTY_PAGE, session: "present" });
  const text = typeof kept === "string" ? kept : JSON.stringify(kept);
  const storage = new Map<string, string>(kept === null ? [] : [["tendril-lock", text]]);
  const now = { ms: 1e12, touched: true, held: false };
  const keeps = {
    getItem: (key: string) => storage.get(key) ?? null,
    setItem: (key: string, value: string) => void storage.set(key, value),
    removeItem: (key: string) => void storage.delete(key),
  };
  const port = { now: () => now.ms, isTouched: () => now.touched, isHeld: () => now.held };
  const lock = new TouchLock(page, keeps, port);
  const pass = (seconds: number) => {
    now.ms += 1e3 * seconds;
    lock.look();
  };
  return { page, storage, now, lock, pass, reopen: () => new TouchLock(page, keeps, port) };
}

const locked = { after: 30, by: "hold", locked: true };

test("a page that no one touches locks itself after the time that was chosen, and by default never", () => {
  const { page, lock, pass } = tablet();
  pass(86_400);
  expect(page.get().locked).toBe(false);
  lock.choose({ after: 30 });
  lock.touched();
  pass(29.9);
  lock.touched();
  pass(29.9);
  expect(page.get().locked).toBe(false);
  pass(0.1);
  expect(page.get().locked).toBe(true);
  lock.unlock();
  pass(29.9);
  expect(page.get().locked).toBe(false);
});

test("a touch that comes after the time locks it, however late the page looks: a phone has slept", () => {
  const { page, now, lock } = tablet({ after: 30, by: "slide" });
  now.ms += 3.6e6;
  lock.touched();
  expect(page.get().locked).toBe(true);
});

test("it does not lock under a hand that holds the target, nor a screen that is not touched", () => {
  const { page, now, pass } = tablet({ after: 30, by: "slide" });
  now.held = true;
  pass(60);
  now.held = false;
  pass(29);
  expect(page.get().locked, "from when it was let go").toBe(false);
  now.touched = false;
  pass(60);
  expect(page.get().locked).toBe(false);
});

test("large numbers and the sign-in have nothing to lock, and what was locked before is so again after", () => {
  const { page, pass, lock } = tablet({ after: 30, by: "slide" });
  page.patch({ view: "wall" });
  pass(60);
  page.patch({ view: "live" });
  expect(page.get().locked).toBe(false);
  lock.lock();
  expect(isLocked(page.get())).toBe(true);
  expect([isLocked({ ...page.get(), view: "wall" }), isLocked({ ...page.get(), session: "absent" })]).toEqual([false, false]); // prettier-ignore
});

test("time, confirmation and lock outlive a reload; what was not written here is the default", () => {
  const { page, lock, reopen } = tablet();
  lock.choose({ after: 120, by: "number" });
  lock.lock();
  page.patch({ locked: false });
  expect(reopen().choice.get()).toEqual({ after: 120, by: "number" });
  expect(page.get().locked).toBe(true);
  for (const odd of ["", "null", "3", "[]", '{"after":31,"by":"force","locked":"yes"}']) {
    const other = tablet(odd);
    expect(other.lock.choice.get(), odd).toEqual({ after: 0, by: "slide" });
    expect(other.page.get().locked).toBe(false);
  }
  expect(tablet(locked).page.get().locked).toBe(true);
});

test("a thumb follows a finger and steps by keys, and does not jump to where the way is touched", () => {
  expect([slid(0, 5), slid(60, 100), slid(50, 20)]).toEqual([5, 100, 20]);
  expect([slid(0, 100), slid(0, 41), slid(55, 100)]).toEqual([0, 0, 55]);
});
