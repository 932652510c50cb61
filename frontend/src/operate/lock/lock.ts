import type { Page } from "../../live/page";
import { quietly, type PageStorage } from "../../ui/storage";
import { Store } from "../../ui/store";

const KEY = "tendril-lock";
const CHECK_MS = 500;
/** A thumb that goes further between two events was not slid there, but put there by a touch elsewhere [%]. */
const JUMP = 40;

/** For how long no one touches the page before it locks itself [s]; 0: it does not. */
export const TIMES = [0, 30, 120, 600] as const;
/** What unlocks it: a thumb slid along its whole way, a press of one second, or a number that is typed. */
export const WAYS = ["slide", "hold", "number"] as const;
export type Way = (typeof WAYS)[number];

export interface LockChoice {
  /** One of `TIMES`. */
  readonly after: number;
  readonly by: Way;
}

/** What the lock needs from outside, so that tests can hold the clock. */
export interface LockPort {
  /** Time of day [ms]: the page's own clock stands still while a phone sleeps. */
  now(): number;
  /** This screen is one that is touched. */
  isTouched(): boolean;
  /** Something holds the target. */
  isHeld(): boolean;
}

/** Locks a page that no one has touched for a while: what a pocket or a child then presses does nothing.
 *
 * The stops always work: one that was not meant costs a moment, one that is refused may cost the actuator. What moves
 * goes on: a long run is watched without touching anything. */
export class TouchLock {
  /** Kept by the browser. */
  readonly choice: Store<LockChoice>;
  private touchedAt: number;

  constructor(
    private readonly page: Store<Page>,
    private readonly storage: PageStorage,
    private readonly port: LockPort,
  ) {
    const { locked, ...choice } = kept(quietly(() => storage.getItem(KEY)));
    this.choice = new Store<LockChoice>(choice);
    this.touchedAt = port.now();
    if (locked && port.isTouched()) page.patch({ locked }); // a reload is no confirmation
  }

  /** Hear every touch and key of the page, and look at the time. */
  start(): void {
    for (const name of ["pointerdown", "pointermove", "pointerup", "wheel", "keydown"])
      window.addEventListener(name, () => this.touched(), { capture: true, passive: true }); // prettier-ignore
    document.addEventListener("visibilitychange", () => this.look()); // prettier-ignore
    setInterval(() => this.look(), CHECK_MS); // prettier-ignore
  }

  /** Someone touched the page, or a frame in it; one that comes too late no longer counts. */
  touched(): void {
    this.look();
    this.touchedAt = this.port.now();
  }

  look(): void {
    const { after } = this.choice.get();
    const now = this.port.now();
    if (this.port.isHeld() || !this.port.isTouched() || !isLockable(this.page.get())) this.touchedAt = now;
    else if (after > 0 && now - this.touchedAt >= after * 1e3) this.lock();
  }

  lock(): void {
    this.put(true);
  }

  unlock(): void {
    this.touchedAt = this.port.now();
    this.put(false);
  }

  choose(change: Partial<LockChoice>): void {
    this.touchedAt = this.port.now();
    this.choice.patch(change);
    this.keep();
  }

  private put(locked: boolean): void {
    if (this.page.get().locked === locked) return;
    this.page.patch({ locked });
    this.keep();
  }

  private keep(): void {
    const { locked } = this.page.get();
    quietly(() => {
      this.storage.setItem(KEY, JSON.stringify({ ...this.choice.get(), locked }));
    });
  }
}

/** The large numbers have nothing to press, and the sign-in nothing that acts. */
function isLockable({ session, view }: Page): boolean {
  return session === "present" && view !== "wall";
}

/** Whether the lock lies over the page now. */
export function isLocked(page: Page): boolean {
  return page.locked && isLockable(page);
}

/** Where a thumb at `at` stands once the browser puts it to `next` [%]. */
export function slid(at: number, next: number): number {
  return next - at > JUMP ? at : next;
}

function kept(text: string | null): LockChoice & { readonly locked: boolean } {
  const found: unknown = text === null ? null : quietly(() => JSON.parse(text) as unknown);
  const { after, by, locked } = (found ?? {}) as Partial<Record<"after" | "by" | "locked", unknown>>;
  return {
    after: TIMES.find((time) => time === after) ?? 0,
    by: WAYS.find((way) => way === by) ?? "slide",
    locked: locked === true,
  };
}
