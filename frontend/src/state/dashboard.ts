import { rest, Refusal } from "../api/rest";
import { LiveSocket, liveUrl } from "../api/socket";
import type { CommandBody, Event, FromServer, Point, Settings } from "../api/types";
import { handleOf, type Handle, type Wish } from "./handle";
import { Live } from "./live";
import { asCause, asMode } from "./modes";
import { EMPTY_PAGE, keep, situation, withLine, type Page } from "./page";
import { whyNot, type Control } from "./permission";
import { Store } from "./store";
import { TargetSender } from "./target";
import { Ticker } from "./ticker";

export type Notify = (level: Event["level"], title: string, text: string) => void;

const CHECK_MS = 100;
const RIG_SILENT_MS = 700;
const PING_MS = 1000;

/** The page's one connection to the server: what arrives goes to `live` and `page`, what is asked goes out. */
export class Dashboard {
  readonly live = new Live();
  readonly page = new Store<Page>(EMPTY_PAGE);
  readonly ticker = new Ticker();
  readonly targets: TargetSender;
  wish: Wish | null = null;
  private readonly socket: LiveSocket;
  private presence = 0;
  private boot: number | null = null;
  private checkedAt = 0;

  constructor(private readonly notify: Notify) {
    this.socket = new LiveSocket(liveUrl(window.location), {
      opened: () => {
        this.page.patch({ online: true });
      },
      closed: () => {
        this.disconnected();
      },
      message: (message) => {
        this.receive(message);
      },
      binary: (buffer) => {
        this.frame(buffer);
      },
    });
    this.targets = new TargetSender({
      send: (message) => this.socket.send(message),
      now: () => performance.now(),
      later: (action, delay) => setTimeout(action, delay),
    });
  }

  /** Connect if this browser has a session; else ask for the token. */
  async start(): Promise<void> {
    setInterval(() => {
      this.checkRig(performance.now());
    }, CHECK_MS);
    setInterval(() => this.socket.send({ type: "ping", t: performance.now() }), PING_MS);
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

  /** Ask the rig for a change of state; refusals are shown with the rig's own words. */
  async command(body: CommandBody): Promise<void> {
    const emergency = body.request === "e_stop";
    try {
      const reply = await rest.command(body);
      if (!reply.accepted) this.notify("warning", "Refused", reply.detail);
    } catch (error) {
      this.report(error, emergency ? "E-STOP did not reach the rig: use the hardware stop" : "Refused");
    }
  }

  /** Run `action`; if the server refuses, show its text under `title`. */
  async attempt(title: string, action: () => Promise<unknown>): Promise<boolean> {
    try {
      await action();
      return true;
    } catch (error) {
      this.report(error, title);
      return false;
    }
  }

  async takeLease(): Promise<void> {
    await this.attempt("Control not taken", async () => {
      this.page.patch({ lease: await rest.takeLease() });
    });
  }

  async releaseLease(): Promise<void> {
    await this.attempt("Control not released", () => rest.releaseLease());
  }

  /** Change live settings; throws the server's refusal, so that it can be shown at the input. */
  async changeSettings(changes: Partial<Settings>): Promise<void> {
    const settings = await rest.changeSettings(changes);
    this.page.patch({ settings: keep(this.page.get().settings, settings) });
  }

  async toggleRecording(): Promise<void> {
    const reason = this.whyNot("record");
    const { recording, recordingName } = this.page.get();
    if (reason !== null) this.notify("warning", "Recording", reason);
    else if (recording.recording) await this.attempt("Recording not stopped", () => rest.stopRecording());
    else
      await this.attempt("Recording not started", async () => {
        this.page.patch({ recording: await rest.startRecording(recordingName) });
      });
  }

  /** Follow the target where its handle stands now. */
  async follow(): Promise<void> {
    const reason = this.whyNot("follow");
    const handle = this.handle(performance.now());
    if (reason !== null) this.page.patch({ hint: reason });
    else if (handle) await this.command({ request: "follow", target: [handle.point[0], handle.point[1]] });
  }

  /** Esc: HOLD where that means something; elsewhere it is only the first half of Esc Esc. */
  holdByKey(): void {
    if (this.whyNot("hold") === null) void this.command({ request: "hold" });
  }

  /** Arrow keys: move the target by (dx, dy) [m] from where it is wanted now. */
  nudge(dx: number, dy: number, fresh: boolean): void {
    const handle = this.handle(performance.now());
    if (handle) this.moveTarget([handle.point[0] + dx, handle.point[1] + dy], fresh, false);
  }

  whyNot(control: Control): string | null {
    return whyNot(control, situation(this.page.get()));
  }

  /** Move the target to `point` if that is allowed now, else say why not; `fresh` marks a new press. */
  moveTarget(point: Point, fresh: boolean, held: boolean): boolean {
    const hint = this.whyNot("drag");
    this.page.patch({ hint: hint ?? "" });
    if (hint !== null) return false;
    this.wish = { point, at: performance.now(), held };
    this.targets.move(point, fresh);
    return true;
  }

  /** The pointer let go of the target: from now on the rig's word counts. */
  releaseTarget(): void {
    if (this.wish) this.wish = { ...this.wish, at: performance.now(), held: false };
  }

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

  private async enter(): Promise<void> {
    try {
      await rest.session();
      this.page.patch({ session: "present" });
      this.socket.start();
    } catch (error) {
      if (error instanceof Refusal && error.status === 401) this.page.patch({ session: "absent" });
      else setTimeout(() => void this.enter(), PING_MS);
    }
  }

  private report(error: unknown, title: string): void {
    const text = error instanceof Error ? error.message : String(error);
    this.notify("error", title, text);
    const event = {
      type: "event" as const,
      time: new Date().toISOString(),
      level: "error" as const,
      text: `${title}: ${text}`,
    };
    this.page.patch({ log: withLine(this.page.get().log, event) });
  }

  private disconnected(): void {
    const wasOnline = this.page.get().online;
    this.page.patch({ online: false, rigLive: false });
    this.targets.reset();
    if (wasOnline || this.page.get().session !== "present") return;
    rest.session().catch((error: unknown) => {
      if (!(error instanceof Refusal) || error.status !== 401) return;
      this.socket.stop();
      this.page.patch({ session: "absent" });
    });
  }

  private receive(message: FromServer): void {
    const page = this.page.get();
    switch (message.type) {
      case "hello":
        this.live.describe(message.layout, message.channels);
        this.page.patch({ lease: keep(page.lease, message.session.lease), log: [] });
        this.meet(message.rig);
        return;
      case "status":
        this.page.patch({
          lease: keep(page.lease, message.lease),
          settings: keep(page.settings, message.settings),
          recording: message.recording,
          health: message.health,
        });
        this.meet(message.rig);
        return;
      case "reply":
        this.targets.answered(message.id);
        this.page.patch({ hint: message.reply.accepted ? "" : message.reply.detail });
        return;
      case "refused":
        this.targets.answered(message.id);
        this.page.patch({ hint: message.detail });
        return;
      case "pong":
        this.live.roundTrip = (performance.now() - message.t) / 1e3;
        return;
      case "event":
        this.page.patch({ log: withLine(page.log, message) });
        return;
    }
  }

  private meet(rig: Page["rig"]): void {
    this.page.patch({ rig: keep(this.page.get().rig, rig) });
    if (!rig || rig.boot === this.boot) return;
    if (this.boot !== null) this.live.forget();
    this.boot = rig.boot;
    void this.attempt("Reach not known", async () => {
      this.page.patch({ workspace: await rest.workspace() });
    });
  }

  private frame(buffer: ArrayBuffer): void {
    const { live } = this;
    if (!live.take(buffer, performance.now()) || !live.telemetry) return;
    this.page.patch({
      mode: asMode(live.telemetry.at("mode")),
      cause: asCause(live.telemetry.at("cause")),
      saturated: live.telemetry.at("saturated") === 1,
      reachable: live.telemetry.at("reachable") === 1,
    });
  }

  private sendPresence(): void {
    if (!this.page.get().lease.mine) return;
    this.presence += 1;
    this.socket.send({ type: "presence", n: this.presence });
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
