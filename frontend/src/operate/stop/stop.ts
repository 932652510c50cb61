import { api, Refusal, dataOf } from "../../api/rest";
import type { CommandReply } from "../../api/types";
import type { Page, StopNews } from "../../live/page";
import { MODE } from "../../live/modes";
import { textOf } from "../../ui/format";
import type { Store } from "../../ui/store";

/** Every way from this page to the rig, the quickest first. */
const WAYS = ["socket", "http"] as const;
type Way = (typeof WAYS)[number];
const NAME: Record<Way, string> = { socket: "live connection", http: "web request" };

/** How one way stands: `lost` is tried again, `refused` is not. */
interface Standing {
  readonly state: "waiting" | "arrived" | "refused" | "lost";
  readonly why: string;
}

const WAITING: Standing = { state: "waiting", why: "no answer yet" };

/** What an E-STOP needs from outside, so that tests can hold the clock and cut the ways. */
export interface StopPort {
  /** Hand it to the live socket; false where that is closed. The answer comes by `answered`. */
  bySocket(n: number): boolean;
  byHttp(): Promise<CommandReply>;
  show(news: StopNews | null): void;
  /** No way was left: for the page's log, once for each press. */
  write(title: string, error: unknown): void;
  later(action: () => void, delay: number): void;
}

/** An E-STOP that did not get through is sent again for 10 s; a late stop does no harm. */
const ATTEMPTS_MAX = 20;
const RETRY_MS = 500;
/** Tries without any answer after which it is said that nothing arrives. */
const TRIES_MAX = 2;
const ARRIVED_SHOWN_MS = 4000;
const LOST_SHOWN_MS = 30_000;
const TITLE = "E-STOP did not reach the rig: use the hardware stop";

/** By HTTP it goes before what else the browser fetches, and goes on when the page is closed. */
export function stopByHttp(): Promise<CommandReply> {
  const how: RequestInit = { priority: "high", keepalive: true };
  return dataOf(api.POST("/api/command", { ...how, body: { request: "e_stop" } }));
}

/** E-STOP: for every viewer, in every state, at once by every way there is, until one of them has arrived. */
export class EmergencyStop {
  /** Names the press: answers to an earlier one say nothing about this one. */
  private n = 0;
  private tries = 0;
  private written = false;
  private standing: Record<Way, Standing> = { socket: WAITING, http: WAITING };

  constructor(private readonly port: StopPort) {}

  press(): void {
    this.n += 1;
    this.tries = 0;
    this.written = false;
    this.standing = { socket: WAITING, http: WAITING };
    this.send(this.n);
  }

  /** The socket's answer to press `n`; `refusal` is "" if the rig took it. */
  answered(n: number, refusal: string): void {
    this.settle(n, "socket", { state: refusal === "" ? "arrived" : "refused", why: refusal });
  }

  /** The rig has left E-STOP: that it had arrived is no news any more. */
  cleared(): void {
    if (this.has("arrived").length === 0) return;
    this.n += 1;
    this.port.show(null);
  }

  private send(n: number): void {
    this.tries += 1;
    const first = this.tries === 1;
    if (this.standing.socket.state !== "refused")
      this.stand("socket", this.port.bySocket(n) ? WAITING : { state: "lost", why: "no connection" });
    if (first || this.standing.http.state === "lost") {
      this.stand("http", WAITING);
      void this.sendByHttp(n);
    }
    this.tell();
    this.port.later(() => {
      if (n === this.n && this.tries < ATTEMPTS_MAX && !this.isOver()) this.send(n);
    }, RETRY_MS);
  }

  private async sendByHttp(n: number): Promise<void> {
    try {
      const reply = await this.port.byHttp();
      this.settle(n, "http", { state: reply.accepted ? "arrived" : "refused", why: reply.detail });
    } catch (error) {
      const why = textOf(error);
      this.settle(n, "http", { state: error instanceof Refusal ? "refused" : "lost", why });
    }
  }

  private settle(n: number, way: Way, found: Standing): void {
    if (n !== this.n || this.standing[way].state === "arrived") return;
    this.stand(way, found);
    this.tell();
  }

  private stand(way: Way, found: Standing): void {
    this.standing = { ...this.standing, [way]: found };
  }

  private has(state: Standing["state"]): Way[] {
    return WAYS.filter((way) => this.standing[way].state === state);
  }

  private isOver(): boolean {
    return this.has("arrived").length > 0 || this.has("refused").length === WAYS.length;
  }

  private isLost(): boolean {
    const open = this.has("waiting").length > 0 && this.tries <= TRIES_MAX;
    return this.has("arrived").length === 0 && !open;
  }

  private tell(): void {
    const arrived = this.has("arrived");
    if (arrived.length > 0) this.show({ phase: "arrived", text: arrivedText(this.standing) });
    else if (this.isLost()) this.tellLost();
    else this.port.show({ phase: "sent", text: "E-STOP sent" });
  }

  private tellLost(): void {
    const why = WAYS.map((way) => `${NAME[way]}: ${this.standing[way].why}`).join("; ");
    this.show({ phase: "lost", text: `${TITLE} (${why})` });
    if (!this.written) this.port.write(TITLE, new Error(why));
    this.written = true;
  }

  private show(news: StopNews): void {
    const { n } = this;
    this.port.show(news);
    this.port.later(
      () => {
        if (n === this.n && news.phase === (this.isLost() ? "lost" : "arrived")) this.port.show(null);
      },
      news.phase === "lost" ? LOST_SHOWN_MS : ARRIVED_SHOWN_MS,
    );
  }
}

/** Tell `stop` when the rig leaves E-STOP. */
export function watchLatch(stop: Pick<EmergencyStop, "cleared">, page: Store<Page>): void {
  let last = page.get().mode;
  page.subscribe(() => {
    const { mode } = page.get();
    if (mode !== last && last === MODE.E_STOP && mode !== null) stop.cleared();
    last = mode;
  });
}

/** Sent twice for certainty, it has arrived once; only a way that failed is worth a word. */
function arrivedText(standing: Record<Way, Standing>): string {
  const failed = WAYS.filter((way) => ["refused", "lost"].includes(standing[way].state));
  return `E-STOP arrived at the rig${failed.map((way) => ` (${NAME[way]}: ${standing[way].why})`).join("")}`;
}
