import type { Point } from "../api/types";
import { handleOf, type Handle, type Wish } from "./handle";
import type { Live } from "./live";
import { MODE } from "./modes";
import type { Operations } from "./operations";
import type { Page } from "./page";
import type { Store } from "./store";
import { TargetSender, type TargetPort } from "./target";

const HINT_MS = 4000;

/** The operator's hand on the target: by pointer, by arrow keys, by the Follow button. */
export class Aim {
  readonly targets: TargetSender;
  private wish: Wish | null = null;
  /** The rig followed the present drag: if it holds now, only a new press may move it again. */
  private followed = false;
  private hintTimer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly live: Live,
    private readonly page: Store<Page>,
    private readonly operations: Operations,
    send: TargetPort["send"],
  ) {
    this.targets = new TargetSender({
      send,
      now: () => performance.now(),
      later: (action, delay) => setTimeout(action, delay),
    });
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
    return true;
  }

  /** The pointer let go of the target: from now on the rig's word counts. */
  release(): void {
    if (this.wish) this.wish = { ...this.wish, at: performance.now(), held: false };
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
    this.hint(refusal);
  }

  disconnected(): void {
    this.wish = null;
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
      this.hintTimer = setTimeout(() => {
        this.page.patch({ hint: "" });
      }, HINT_MS);
    }
    this.page.patch({ hint: text });
  }
}
