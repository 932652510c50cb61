import type { FromBrowser, Point } from "../../api/types";

type TargetMessage = Extract<FromBrowser, { type: "target" }>;

/** What the sender needs from outside, so that tests can hold the clock. */
export interface TargetPort {
  send(message: TargetMessage): boolean;
  now(): number;
  later(action: () => void, delay: number): void;
}

interface Wish {
  readonly point: Point;
  readonly start: boolean;
  readonly at: number;
}

const GAP_MS = 4;
/** Targets that may wait for the rig's answer: enough for 80 ms of round trip at 50 Hz, too few to build a queue. */
const WINDOW = 4;
const ANSWER_MS = 250;
const KEPT = 10_000;

/** Sends the newest wish at the pointer's own rate, never faster than every 4 ms, and times the rig's answers. */
export class TargetSender {
  /** Handler-to-reply times [ms], newest last. */
  readonly roundTrips: number[] = [];
  private readonly waiting = new Map<number, number>();
  private wish: Wish | null = null;
  private id = 0;
  private sentAt = -Infinity;
  private wakeAt = Infinity;

  constructor(private readonly port: TargetPort) {}

  /** The operator wants the target at `point`; `start` marks a fresh press and is never lost to a newer move. */
  move(point: Point, start: boolean): void {
    const at = this.port.now();
    this.wish = { point, start: start || (this.wish?.start ?? false), at };
    this.flush();
  }

  /** The server answered target `id`; older ones will not be answered any more. */
  answered(id: number): void {
    const at = this.waiting.get(id);
    if (at !== undefined) this.keep(this.port.now() - at);
    for (const older of this.waiting.keys()) if (older <= id) this.waiting.delete(older);
    this.flush();
  }

  /** The connection is gone: nothing is on its way any more, and an old wish must not come alive later. */
  reset(): void {
    this.waiting.clear();
    this.drop();
  }

  /** Forget a wish that has not gone out yet. */
  drop(): void {
    this.wish = null;
  }

  private flush(): void {
    if (!this.wish) return;
    const now = this.port.now();
    this.forget(now);
    const due = this.sentAt + GAP_MS - now;
    if (due > 0) this.wait(due);
    else if (this.waiting.size >= WINDOW) this.wait(ANSWER_MS);
    else this.sendWish(this.wish, now);
  }

  private sendWish({ point, start, at }: Wish, now: number): void {
    const [x, y] = point;
    this.wish = null;
    this.id += 1;
    if (!this.port.send({ type: "target", id: this.id, x, y, start })) return;
    this.sentAt = now;
    this.waiting.set(this.id, at);
  }

  /** Try again after `delay`, unless an earlier try is set already. */
  private wait(delay: number): void {
    const at = this.port.now() + delay;
    if (at >= this.wakeAt) return;
    this.wakeAt = at;
    this.port.later(() => {
      if (this.wakeAt === at) this.wakeAt = Infinity;
      this.flush();
    }, delay);
  }

  private forget(now: number): void {
    for (const [id, at] of this.waiting) if (now - at > ANSWER_MS) this.waiting.delete(id);
  }

  private keep(roundTrip: number): void {
    this.roundTrips.push(roundTrip);
    if (this.roundTrips.length > KEPT) this.roundTrips.shift();
  }
}
