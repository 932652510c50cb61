import { api, forgetAnswers, isOutdated, Refusal, dataOf } from "../api/rest";
import { LayoutError, type LiveSocket } from "../api/socket";
import type { FromServer, Health, Lease, Role, Session } from "../api/types";
import { asCause, asMode } from "./modes";
import type { Store } from "../ui/store";
import type { Live } from "./live";
import { plain } from "../ui/format";
import { keep, withLines, type Page } from "./page";
import { errorOf } from "./telemetry";
import type { PageName } from "./presence/presence";

const CHECK_MS = 100;
/** Pictures come 60 times a second: without any for so long, something is silent. */
const SILENT_MS = 700;
/** Nothing heard for so long: the server is asked whether it is there, at every check. */
const ASK_MS = 300;
/** The most that a slow network adds to `SILENT_MS` where answers are all that comes. */
const SLOW_MS_MAX = 2000;
const PING_MS = 1000;
/** What was still for less gave its signs in time [ms]; a lapse that comes later has another reason. */
const STILL_MS = 2000;
const STILL_NEWS_MS = 10_000;
/** Where the tabs of one browser tell each other that they signed in. */
const TABS = "tendril-session";

/** What the rest of the page hears from the connection beside `live` and `page`. */
export interface ConnectionListener {
  /** The rig answered target `id`, or the server refused it; "" if it was accepted. */
  answered(id: number, refusal: string): void;
  /** The same of E-STOP `n`. */
  stopAnswered(n: number, refusal: string): void;
  disconnected(): void;
  /** A rig was met, or another start of it. */
  met(): void;
  /** I operate now, or no longer do; no one asked for it here. `still`: what kept this page from giving signs. */
  leaseChanged(lease: Lease, still: string): void;
  failed(title: string, error: unknown): void;
}

type Answered = Pick<Extract<FromServer, { type: "reply" | "refused" }>, "id" | "n">;

/** The page's one live connection: what arrives goes to `live` (the stream) and `page` (what controls show). */
export class Connection {
  private readonly tabs = new BroadcastChannel(TABS);
  private signingIn: Promise<void> | null = null;
  /** How the server names this page, while its live socket is open. */
  private name: PageName = null;
  private boot: number | null = null;
  private checkedAt = 0;
  /** Page clock [ms] when the server said anything. */
  private heardAt = -Infinity;
  /** What last kept this page from giving signs, and until when [ms]. */
  private still = { why: "", until: -Infinity };

  constructor(
    private readonly live: Live,
    private readonly page: Store<Page>,
    private readonly socket: LiveSocket,
    private readonly listener: ConnectionListener,
  ) {
    socket.tell({
      opened: () => this.opened(),
      closed: () => this.closed(),
      message: (message) => {
        this.heard();
        this.receive(message);
      },
      binary: (buffer) => {
        this.heard();
        this.guard(() => {
          this.frame(buffer);
        });
      },
    });
  }

  /** Start the clocks, and connect if this browser has a session; else the page asks for the token. */
  async start(): Promise<void> {
    setInterval(() => this.checkRig(performance.now()), CHECK_MS);
    setInterval(() => this.ping(performance.now()), PING_MS);
    this.startPresence();
    this.tabs.onmessage = () => void this.enter();
    await this.enter();
  }

  /** Sign in; asked twice at once it is done once, or the live socket could be of another session than the cookie. */
  async login(token: string): Promise<void> {
    this.signingIn ??= this.signIn(token).finally(() => {
      this.signingIn = null;
    });
    await this.signingIn;
  }

  private async signIn(token: string): Promise<void> {
    await api.POST("/api/session", { body: { token } });
    this.tabs.postMessage(null);
    await this.enter();
  }

  /** Sign out, in all tabs of this browser. */
  async logout(): Promise<void> {
    await api.DELETE("/api/session");
    this.tabs.postMessage(null);
    await this.enter();
  }

  /** Sign out every session of this role's token; this one, too, if it is one of them. */
  async logoutAll(role: Role): Promise<void> {
    await api.DELETE("/api/sessions/{role}", { params: { path: { role } } });
    await this.enter();
  }

  /** The worker asks whether this page still answers, and gives its signs while it does. */
  private startPresence(): void {
    const worker = new Worker(new URL("./presence/presence.worker.ts", import.meta.url), { type: "module" });
    worker.onmessage = () => {
      worker.postMessage(this.page.get().lease.mine ? this.name : null);
    };
    worker.onerror = () => {
      this.listener.failed(
        "The rig will not stay in motion",
        "this page's presence worker failed: reload the page",
      );
    };
    const leave = () => worker.postMessage(null);
    window.addEventListener("pagehide", leave);
    document.addEventListener("freeze", leave);
  }

  /** Have the server send these channels (keys) and no others, now and after every reconnection. */
  plot(keys: readonly string[]): void {
    this.socket.send(this.live.plot(keys));
  }

  /** Connect as the session of this browser's cookie; a socket of the session before, from another tab, ends. */
  private async enter(): Promise<void> {
    try {
      const session = await dataOf(api.GET("/api/session"));
      const { session: before, me } = this.page.get();
      this.page.patch({ session: "present", me: mine(session) });
      if (before === "present" && (me.name !== session.name || me.role !== session.role))
        this.socket.restart();
      else this.socket.start();
    } catch (error) {
      if (isSignedOut(error)) this.leave();
      else setTimeout(() => void this.enter(), PING_MS);
    }
  }

  private opened(): void {
    this.wasStill("its connection was gone", this.heardAt);
    this.heard();
    this.page.patch({ online: true, shutOut: "" });
  }

  private heard(): void {
    this.heardAt = performance.now();
    if (this.page.get().unheard) this.page.patch({ unheard: false });
  }

  /** Until now, and since `since` [ms], this page could give no sign. */
  private wasStill(why: string, since: number): void {
    const [until, ms] = [performance.now(), performance.now() - since];
    if (ms > STILL_MS && Number.isFinite(ms))
      this.still = { why: `${why} for ${plain(ms / 1e3, 0)} s`, until };
  }

  /** Why the server may have heard nothing of this page just now, "" where nothing is known. */
  private stillness(): string {
    return performance.now() - this.still.until < STILL_NEWS_MS ? this.still.why : "";
  }

  private closed(): void {
    const wasOnline = this.page.get().online;
    this.name = null;
    this.page.patch({ online: false, unheard: false, rigLive: false });
    this.live.roundTrip.forget();
    this.listener.disconnected();
    if (!wasOnline) void this.askWhy();
  }

  /** No socket came about: the session may be over, or there are too many pages. */
  private async askWhy(): Promise<void> {
    try {
      await api.GET("/api/live");
      this.page.patch({ shutOut: "" });
    } catch (error) {
      this.page.patch({ shutOut: error instanceof Refusal ? error.message : "" });
      if (isSignedOut(error)) this.leave();
    }
  }

  /** The session is over: the page asks for the token. */
  private leave(): void {
    this.socket.stop();
    this.page.patch({ session: "absent" });
  }

  private receive(message: FromServer): void {
    const page = this.page.get();
    switch (message.type) {
      case "hello":
        this.name = message.page;
        forgetAnswers();
        if (page.lease.mine && !message.session.lease.mine)
          this.listener.leaseChanged(message.session.lease, this.stillness());
        this.guard(() => {
          this.live.describe(message.layout, message.channels);
          this.socket.send(this.live.choice());
        });
        this.page.patch({
          me: keep(page.me, mine(message.session)),
          lease: keep(page.lease, message.session.lease),
          log: withLines(this.page.get().log, message.log),
        });
        this.meet(message.rig);
        return;
      case "status":
        if (isOutdated(message.read_at)) return; // the next one comes within a second
        this.page.patch({
          lease: keep(page.lease, message.lease),
          people: keep(page.people, message.people),
          settings: keep(page.settings, message.settings),
          recording: keep(page.recording, withBookmarks(page.recording, message.recording)),
          health: keep(page.health, message.health),
          starting: startingWith(message.health, page),
          run: keep(page.run, message.run),
          result: keep(page.result, message.result),
          macro: keep(page.macro, message.macro),
          firstMode: keep(page.firstMode, message.first_mode),
          stoppedBy: message.stopped_by,
          missed: message.missed,
        });
        if (page.lease.mine !== message.lease.mine)
          this.listener.leaseChanged(message.lease, this.stillness());
        this.noteProblem(page.recording.problem, message.recording.problem);
        this.meet(message.rig);
        return;
      case "reply":
        this.answer(message, message.reply.accepted ? "" : message.reply.detail);
        return;
      case "refused":
        this.answer(message, message.detail);
        return;
      case "pong":
        this.live.roundTrip.answered(message.t, performance.now());
        return;
      case "event":
        this.page.patch({ log: withLines(page.log, [message]) });
        return;
    }
  }

  private answer({ id, n }: Answered, refusal: string): void {
    if (n === null) this.listener.answered(id, refusal);
    else this.listener.stopAnswered(n, refusal);
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
    if (now !== "" && now !== before) this.listener.failed("Trouble with recording", now);
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
      this.page.patch({ workspace: await dataOf(api.GET("/api/workspace")) });
    } catch (error) {
      this.listener.failed("Reach not known", error);
    }
  }

  private frame(buffer: ArrayBuffer): void {
    const [{ live }, now] = [this, performance.now()];
    if (buffer.byteLength === 0 || !live.take(buffer, now) || !live.telemetry) return;
    const mode = asMode(live.telemetry.at("mode"));
    this.page.patch({
      mode,
      errorOf: errorOf(live.telemetry, mode),
      cause: asCause(live.telemetry.at("cause")),
      saturated: live.telemetry.at("saturated") === 1,
      reachable: live.telemetry.at("reachable") === 1,
    });
    if (live.freshAt === now && !this.page.get().rigLive) this.judge(now);
  }

  private ping(now: number): void {
    const roundTrip = this.live.roundTrip.at(now);
    const known = Number.isFinite(roundTrip) ? roundTrip : null;
    if (this.socket.send({ type: "ping", t: now, round_trip: known })) this.live.roundTrip.sent(now);
  }

  /** A check that itself came late proves nothing. */
  private checkRig(now: number): void {
    const late = now - this.checkedAt > 4 * CHECK_MS;
    if (late && this.checkedAt > 0) this.wasStill("the browser stood still", this.checkedAt);
    this.checkedAt = now;
    if (late) return;
    if (this.page.get().online && now - this.heardAt > ASK_MS) this.ping(now);
    this.judge(now);
    const { rigLive, health } = this.page.get();
    if (rigLive && health) this.page.patch({ starting: health.starting });
  }

  /** Say what falls silent, the nearest first. */
  private judge(now: number): void {
    const { online, health } = this.page.get();
    const silent = now - this.live.freshAt > SILENT_MS && health?.paused !== true;
    const unheard = online && this.isUnheard(now, silent && health?.rig_connected === true);
    const rigLive = online && !unheard && !silent && health?.rig_connected !== false;
    this.page.patch({ unheard, rigLive });
  }

  /** The server says nothing; where `pictures` are missing, it said nothing since the last one either. */
  private isUnheard(now: number, pictures: boolean): boolean {
    if (pictures && this.heardAt - this.live.freshAt < ASK_MS) return true;
    const slow = pictures ? 0 : Math.min(1e3 * (this.live.roundTrip.took || 0), SLOW_MS_MAX);
    return now - this.heardAt > SILENT_MS + slow;
  }
}

/** The server hears the new rig some frames before this page sees it. */
function startingWith(health: Health, page: Page): string {
  return health.starting === "" && health.rig_connected && !page.rigLive ? page.starting : health.starting;
}

/** The bookmarks are the same object while they are the same: plots that draw them stand still. */
function withBookmarks(old: Page["recording"], next: Page["recording"]): Page["recording"] {
  return { ...next, bookmarks: keep(old.bookmarks, next.bookmarks) };
}

function mine({ name, role, unprotected }: Session): Page["me"] {
  return { name, role, unprotected };
}

function isSignedOut(error: unknown): boolean {
  return error instanceof Refusal && error.status === 401;
}
