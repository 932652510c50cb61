import { LayoutError } from "../api/record";
import { Refusal, rest } from "../api/rest";
import { LiveSocket, liveUrl } from "../api/socket";
import type { FromBrowser, FromServer, Session } from "../api/types";
import type { Live } from "./live";
import { asCause, asMode } from "./modes";
import { keep, withLines, type Page } from "./page";
import type { Store } from "./store";

const CHECK_MS = 100;
const RIG_SILENT_MS = 700;
const PING_MS = 1000;

/** What the rest of the page hears from the connection beside `live` and `page`. */
export interface ConnectionListener {
  /** The rig answered target `id`, or the server refused it; "" if it was accepted. */
  answered(id: number, refusal: string): void;
  disconnected(): void;
  /** A rig was met, or another life of it. */
  met(): void;
  /** I operate now, or no longer do; nobody asked for it here. */
  leaseChanged(mine: boolean, holder: string): void;
  failed(title: string, error: unknown): void;
}

/** The page's one live connection: what arrives goes to `live` (the stream) and `page` (what controls show). */
export class Connection {
  private readonly socket: LiveSocket;
  private presence = 0;
  private boot: number | null = null;
  private checkedAt = 0;

  constructor(
    private readonly live: Live,
    private readonly page: Store<Page>,
    private readonly listener: ConnectionListener,
  ) {
    this.socket = new LiveSocket(liveUrl(window.location), {
      opened: () => {
        page.patch({ online: true, shutOut: "" });
      },
      closed: () => {
        this.closed();
      },
      message: (message) => {
        this.receive(message);
      },
      binary: (buffer) => {
        this.guard(() => {
          this.frame(buffer);
        });
      },
    });
  }

  /** Start the clocks, and connect if this browser has a session; else the page asks for the token. */
  async start(): Promise<void> {
    setInterval(() => {
      this.checkRig(performance.now());
    }, CHECK_MS);
    setInterval(() => {
      this.ping();
    }, PING_MS);
    const worker = new Worker(new URL("./presence.worker.ts", import.meta.url), { type: "module" });
    worker.onmessage = () => {
      this.sendPresence();
    };
    await this.enter();
  }

  async login(token: string): Promise<void> {
    await rest.login(token);
    await this.enter();
  }

  send(message: FromBrowser): boolean {
    return this.socket.send(message);
  }

  /** Have the server send these channels (keys) and no others, now and after every reconnection. */
  plot(keys: readonly string[]): void {
    this.send(this.live.plot(keys));
  }

  private async enter(): Promise<void> {
    try {
      const session = await rest.session();
      this.page.patch({ session: "present", me: mine(session) });
      this.socket.start();
    } catch (error) {
      if (isSignedOut(error)) this.page.patch({ session: "absent" });
      else setTimeout(() => void this.enter(), PING_MS);
    }
  }

  private closed(): void {
    const wasOnline = this.page.get().online;
    this.page.patch({ online: false, rigLive: false });
    this.live.roundTrip = NaN;
    this.listener.disconnected();
    if (!wasOnline) void this.askWhy();
  }

  /** No socket came about: the session may be over, or there are too many pages. */
  private async askWhy(): Promise<void> {
    try {
      await rest.mayLookOn();
      this.page.patch({ shutOut: "" });
    } catch (error) {
      this.page.patch({ shutOut: error instanceof Refusal ? error.message : "" });
      if (!isSignedOut(error)) return;
      this.socket.stop();
      this.page.patch({ session: "absent" });
    }
  }

  private receive(message: FromServer): void {
    const page = this.page.get();
    switch (message.type) {
      case "hello":
        this.guard(() => {
          this.live.describe(message.layout, message.channels);
          this.send(this.live.choice());
        });
        this.page.patch({
          me: keep(page.me, mine(message.session)),
          lease: keep(page.lease, message.session.lease),
          log: withLines(page.log, message.log),
        });
        this.meet(message.rig);
        return;
      case "status":
        this.page.patch({
          lease: keep(page.lease, message.lease),
          people: keep(page.people, message.people),
          settings: keep(page.settings, message.settings),
          recording: keep(page.recording, message.recording),
          health: keep(page.health, message.health),
          run: keep(page.run, message.run),
          result: keep(page.result, message.result),
        });
        if (page.lease.mine !== message.lease.mine)
          this.listener.leaseChanged(message.lease.mine, message.lease.holder);
        this.noteProblem(page.recording.problem, message.recording.problem);
        this.meet(message.rig);
        return;
      case "reply":
        this.listener.answered(message.id, message.reply.accepted ? "" : message.reply.detail);
        return;
      case "refused":
        this.listener.answered(message.id, message.detail);
        return;
      case "pong":
        this.live.roundTrip = (performance.now() - message.t) / 1e3;
        return;
      case "event":
        this.page.patch({ log: withLines(page.log, [message]) });
        return;
    }
  }

  /** A message that this page cannot read says so in one notice; the connection goes on. */
  private guard(read: () => void): void {
    try {
      read();
    } catch (error) {
      if (!(error instanceof LayoutError)) throw error;
      this.listener.failed("The server speaks another version", error);
    }
  }

  private noteProblem(before: string, now: string): void {
    if (now !== "" && now !== before) this.listener.failed("The recording ended by itself", now);
  }

  private meet(rig: Page["rig"]): void {
    this.page.patch({ rig: keep(this.page.get().rig, rig) });
    if (!rig || rig.boot === this.boot) return;
    if (this.boot !== null) this.live.forget();
    this.boot = rig.boot;
    void this.learnReach();
    this.listener.met();
  }

  private async learnReach(): Promise<void> {
    try {
      this.page.patch({ workspace: await rest.workspace() });
    } catch (error) {
      this.listener.failed("Reach not known", error);
    }
  }

  private frame(buffer: ArrayBuffer): void {
    const { live } = this;
    if (buffer.byteLength === 0 || !live.take(buffer, performance.now()) || !live.telemetry) return;
    this.page.patch({
      mode: asMode(live.telemetry.at("mode")),
      cause: asCause(live.telemetry.at("cause")),
      saturated: live.telemetry.at("saturated") === 1,
      reachable: live.telemetry.at("reachable") === 1,
    });
  }

  private ping(): void {
    const { roundTrip } = this.live;
    const known = Number.isFinite(roundTrip) ? roundTrip : null;
    this.send({ type: "ping", t: performance.now(), round_trip: known });
  }

  private sendPresence(): void {
    if (!this.page.get().lease.mine) return;
    this.presence += 1;
    this.send({ type: "presence", n: this.presence });
  }

  /** Say so when the rig falls silent; a check that itself came late proves nothing. */
  private checkRig(now: number): void {
    const late = now - this.checkedAt > 4 * CHECK_MS;
    this.checkedAt = now;
    if (late) return;
    const { online, health } = this.page.get();
    const silent = now - this.live.freshAt > RIG_SILENT_MS;
    this.page.patch({ rigLive: online && !silent && health?.rig_connected !== false });
  }
}

function mine({ name, role, unprotected }: Session): Page["me"] {
  return { name, role, unprotected };
}

function isSignedOut(error: unknown): boolean {
  return error instanceof Refusal && error.status === 401;
}
