import type { LiveSocket } from "../../api/socket";
import type { FromBrowser, Point } from "../../api/types";
import type { Live } from "../../live/live";
import type { Page } from "../../live/page";
import { MODE } from "../../live/modes";
import type { Store } from "../../ui/store";
import type { Operations } from "../operations";
import { handleOf, type Handle, type Wish } from "./handle";

type TargetMessage = Extract<FromBrowser, { type: "target" }>;

/** What the sender needs from outside, so that tests can hold the clock. */
export interface TargetPort {
  send(message: TargetMessage): boolean;
  now(): number;
  later(action: () => void, delay: number): void;
}

interface Due {
  readonly point: Point;
  readonly start: boolean;
  readonly at: number;
}

const GAP_MS = 4;
/** Targets that may wait for the rig's answer: enough for 80 ms of round trip at 50 Hz, too few to build a queue. */
const WINDOW = 4;
const ANSWER_MS = 250;
const KEPT = 10_000;
const HINT_MS = 4000;

/** The operator's hand on the target: by pointer, arrow keys, gamepad, or the Follow button. */
export class TargetControl {
  readonly targets: TargetSender;
  private wish: Wish | null = null;
  /** The rig followed the present drag: if it holds now, only a new press may move it again. */
  private followed = false;
  /** Something holds the target: letting go will be said. */
  private gripped = false;
  private hintTimer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly live: Live,
    private readonly page: Store<Page>,
    private readonly operations: Operations,
    private readonly socket: Pick<LiveSocket, "send">,
  ) {
    this.targets = new TargetSender({
      send: (message) => socket.send(message),
      now: () => performance.now(),
      later: (action, delay) => setTimeout(action, delay),
    });
  }

  /** What the hand wants, or wanted last; another object with every move. */
  get wanted(): Wish | null {
    return this.wish;
  }

  /** Something holds the target. */
  get held(): boolean {
    return this.gripped;
  }

  /** Where the target handle stands at page time `now` [ms]. */
  handle(now: number): Handle | null {
    const telemetry = this.live.telemetry;
    if (!telemetry) return null;
    const rig = {
      mode: this.page.get().mode,
      target: telemetry.point("target"),
      reference: telemetry.point("p_ref"),
      tip: telemetry.point("p_hat"),
    };
    return handleOf(this.wish, rig, now);
  }

  /** Move the target to `point` if that is allowed now, else say why not; `fresh` marks a new press. */
  move(point: Point, fresh: boolean, held: boolean): boolean {
    if (fresh) this.followed = false;
    const reason = this.operations.whyNot("drag") ?? this.whyNotOn();
    this.hint(reason ?? "");
    if (reason !== null) return false;
    this.wish = { point, at: performance.now(), held };
    this.targets.move(point, fresh);
    this.gripped = true;
    return true;
  }

  /** Take the target where its handle stands, as a fresh press; null, and a reason on the plan, if that may not be. */
  press(): Point | null {
    const handle = this.handle(performance.now());
    return handle && this.move(handle.point, true, true) ? handle.point : null;
  }

  /** Pointer, key or button let go: from now on the rig's word counts, and with the held clutch on it holds. */
  release(): void {
    if (this.wish) this.wish = { ...this.wish, at: performance.now(), held: false };
    if (!this.gripped) return;
    this.gripped = false;
    if (this.page.get().lease.clutch) this.targets.drop();
    this.socket.send({ type: "release", hold: false });
  }

  /** What the pointer moved on is no longer what it was: the drag ends here, and the rig holds. */
  abort(reason: string): void {
    this.wish = null;
    this.gripped = false;
    this.targets.drop();
    if (!this.socket.send({ type: "release", hold: true })) this.operations.holdByKey();
    this.hint(reason);
  }

  /** Switch the held clutch; a motion that no one holds then ends. */
  async setClutch(clutch: boolean): Promise<void> {
    await this.operations.setClutch(clutch);
    if (clutch && this.page.get().mode === MODE.FOLLOW) this.socket.send({ type: "release", hold: false });
  }

  /** The frame of the 3D view moved under a press; the gizmo can only have been dragged while the rig follows. */
  abortGizmo(): void {
    if (this.page.get().mode === MODE.FOLLOW && this.page.get().lease.mine)
      this.abort("The 3D view moved under the pointer: held. Let go and press again");
  }

  /** Arrow keys: move the target by (dx, dy) [m] from where it is wanted now. */
  nudge(dx: number, dy: number, fresh: boolean): void {
    const handle = this.handle(performance.now());
    if (handle) this.move([handle.point[0] + dx, handle.point[1] + dy], fresh, false);
  }

  /** Follow the target where its handle stands now. */
  async follow(): Promise<void> {
    const reason = this.operations.whyNot("follow");
    const handle = this.handle(performance.now());
    if (reason !== null) this.hint(reason);
    else if (handle)
      await this.operations.command({ request: "follow", target: [handle.point[0], handle.point[1]] });
  }

  /** The rig answered target `id`; `refusal` is "" if it took it. */
  answered(id: number, refusal: string): void {
    this.targets.answered(id);
    if (refusal !== "" || this.gripped) this.hint(refusal); // a drag that was ended says why for its time
  }

  disconnected(): void {
    this.wish = null;
    this.gripped = false;
    this.targets.reset();
  }

  /** Why a drag that goes on moves nothing any more, null if it does. */
  private whyNotOn(): string | null {
    const { mode } = this.page.get();
    this.followed ||= mode === MODE.FOLLOW;
    return this.followed && mode === MODE.HOLD ? "The rig holds: let go and press again" : null;
  }

  /** Say on the plan, for a while, why a touch did nothing. */
  private hint(text: string): void {
    if (text !== "") {
      clearTimeout(this.hintTimer);
      this.hintTimer = setTimeout(() => this.page.patch({ hint: "" }), HINT_MS);
    }
    this.page.patch({ hint: text });
  }
}

/** Sends the newest wish at the pointer's own rate, never faster than every 4 ms, and times the rig's answers. */
export class TargetSender {
  /** Handler-to-reply times [ms], newest last. */
  readonly roundTrips: number[] = [];
  private readonly waiting = new Map<number, number>();
  private wish: Due | null = null;
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

  private sendWish({ point, start, at }: Due, now: number): void {
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
