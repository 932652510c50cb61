import type { Chamber } from "./steps";

/** Between two renewals [ms]: the server lets go 400 ms after the last one. */
export const RENEW_MS = 150;
/** Renewals that may be on their way at once; beyond, the line is too slow for one more to help. */
const ON_THE_WAY = 3;

/** What jogging needs from outside, so that tests can hold clock and network. */
export interface JogPort {
  /** Have the rig fill `chamber`, or none. */
  send(chamber: Chamber | null): Promise<void>;
  every(action: () => void, period: number): ReturnType<typeof setInterval>;
  /** The button that is held, for the page. */
  show(held: Chamber | null): void;
  failed(error: unknown): void;
}

/** A button that is held: its chamber is renewed until it is let go, by whatever way that becomes known. */
export class Jog {
  private held: Chamber | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private onTheWay = 0;

  constructor(private readonly port: JogPort) {}

  press(chamber: Chamber): void {
    if (this.held === chamber) return;
    this.stop();
    this.hold(chamber);
    void this.renew();
    this.timer = this.port.every(() => void this.renew(), RENEW_MS);
  }

  /** Let go of `chamber`, or of whichever is held. */
  release(chamber: Chamber | null = null): void {
    if (this.held === null || (chamber !== null && this.held !== chamber)) return;
    this.stop();
    void this.send(null);
  }

  private stop(): void {
    clearInterval(this.timer);
    this.hold(null);
  }

  private hold(chamber: Chamber | null): void {
    this.held = chamber;
    this.port.show(chamber);
  }

  private async renew(): Promise<void> {
    if (this.held === null || this.onTheWay >= ON_THE_WAY) return;
    this.onTheWay += 1;
    await this.send(this.held);
    this.onTheWay -= 1;
    // A renewal may have been overtaken by the release: it would fill the chamber for another moment
    if (this.isIdle()) await this.send(null);
  }

  private isIdle(): boolean {
    return this.onTheWay === 0 && this.held === null;
  }

  private async send(chamber: Chamber | null): Promise<void> {
    try {
      await this.port.send(chamber);
    } catch (error) {
      if (chamber === null || this.held === null) return; // by itself the chamber empties all the same
      this.stop();
      this.port.failed(error);
    }
  }
}
