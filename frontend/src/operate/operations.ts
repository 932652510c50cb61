import { api, Refusal, dataOf } from "../api/rest";
import type { CommandBody, LogEntry, Lease, Settings } from "../api/types";
import { keep, withLines, type Page } from "../live/page";
import { textOf } from "../ui/format";
import type { Store } from "../ui/store";
import { situation, whyNot, type Control } from "./permission";

export type Notify = (level: LogEntry["level"], title: string, text: string) => void;

/** One part of what is in force when it is sent: an earlier change of the same pair is not taken back. */
export type SettingsChange = (now: Settings) => Partial<Settings>;

/** How the server begins to say that nothing was heard of a page (server/access/lease.py). */
const LAPSED = "nothing was heard";

/** What an operator asks of the server by buttons and keys; refusals are shown in the server's own words. */
export class Operations {
  /** Requests about the lease that this page itself has under way: their outcome is no news. */
  private passing = 0;
  /** The end of the last change that was asked for. */
  private turn: Promise<void> = Promise.resolve();

  constructor(
    private readonly page: Store<Page>,
    readonly notify: Notify,
  ) {}

  whyNot(control: Control): string | null {
    return whyNot(control, situation(this.page.get()));
  }

  /** Ask the rig for another mode. */
  async command(body: CommandBody): Promise<void> {
    await this.attempt("Refused", () => api.POST("/api/command", { body }));
  }

  /** Esc: HOLD where that means something; elsewhere it is only the first half of Esc Esc. */
  holdByKey(): void {
    if (this.whyNot("hold") === null) void this.command({ request: "hold" });
  }

  async takeLease(): Promise<void> {
    await this.pass("Control not taken", api.POST("/api/lease"));
  }

  async releaseLease(): Promise<void> {
    await this.pass("Control not released", api.DELETE("/api/lease"));
  }

  /** Give control to the session `tag`. */
  async handOver(tag: string): Promise<void> {
    await this.pass("Control not handed over", api.POST("/api/lease/hand-over", { body: { tag } }));
  }

  /** Take control from the session `tag`. */
  async takeOver(tag: string): Promise<void> {
    await this.pass("Control not taken over", api.POST("/api/lease/take-over", { body: { tag } }));
  }

  async refuseRequest(tag: string): Promise<void> {
    await this.pass("Request not refused", api.POST("/api/lease/refuse", { body: { tag } }));
  }

  /** Ask the operator for control, or ask no longer. */
  async askForLease(wanted: boolean): Promise<void> {
    const request = "/api/lease/request";
    await this.pass("Control not asked for", wanted ? api.POST(request) : api.DELETE(request));
  }

  /** The lease came or went without this page's doing; a server that knows nothing of mine is another one. */
  leaseChanged({ mine, holder, lost }: Lease, still: string): void {
    if (this.passing > 0) return;
    if (mine) {
      this.notify("info", "You operate now", "Control was handed over to you; the motion is held.");
      return;
    }
    const cause = lost.startsWith(LAPSED) && still !== "" ? ` (${still})` : "";
    const why = lost === "" ? "the server was started again" : `${lost}${cause}`;
    const next = holder === "" ? "take control to go on" : `${holder} operates now`;
    const text = `${why}: ${next}`;
    this.notify("warning", "You no longer operate", text);
    this.write("warning", `You no longer operate: ${text}`);
    this.page.patch({ hint: `Control lost: ${why}` });
  }

  private async pass(title: string, asked: Promise<{ data?: Lease }>): Promise<void> {
    this.passing += 1;
    await this.attempt(title, async () => {
      this.page.patch({ lease: await dataOf(asked), hint: "" });
    });
    this.passing -= 1;
  }

  /** Held clutch: letting go of the target holds the rig. */
  async setClutch(clutch: boolean): Promise<void> {
    await this.attempt("Clutch not changed", async () => {
      this.page.patch({ lease: await dataOf(api.PATCH("/api/lease", { body: { clutch } })) });
    });
  }

  /** Change live settings, one change after the other; what the rig then has is shown. */
  changeSettings(title: string, change: Partial<Settings> | SettingsChange): Promise<void> {
    const send = async () => {
      const { settings: before } = this.page.get();
      const changes = typeof change !== "function" ? change : before ? change(before) : {};
      const settings = await dataOf(api.PATCH("/api/settings", { body: { changes } }));
      this.page.patch({ settings: keep(this.page.get().settings, settings) });
    };
    return this.attemptInTurn(title, send);
  }

  /** Put a controller into the slot, or tune the one that is there: `tuning` by name, all else as usual. */
  chooseController(name: string, tuning: Record<string, number>): Promise<void> {
    return this.attemptInTurn("Controller not changed", async () => {
      const settings = await dataOf(api.PUT("/api/controller", { body: { name, tuning } }));
      this.page.patch({ settings: keep(this.page.get().settings, settings) });
    });
  }

  /** As `attempt`, once all that was asked for in this way before is done: no change takes an earlier one back. */
  attemptInTurn(title: string, action: () => Promise<unknown>): Promise<void> {
    this.turn = this.turn.then(() => this.attempt(title, action));
    return this.turn;
  }

  /** Run `action`; a refusal is shown under `title`, with the server's text. */
  async attempt(title: string, action: () => Promise<unknown>): Promise<void> {
    try {
      await action();
    } catch (error) {
      this.report(title, error);
    }
  }

  /** Show what went wrong; what the server has not written into the log stands in the log of this page. */
  report(title: string, error: unknown): void {
    this.notify("error", title, textOf(error));
    if (!(error instanceof Refusal && error.logged)) this.note(title, error);
  }

  /** Write what went wrong into the log of this page. */
  note(title: string, error: unknown): void {
    this.write("error", `${title}: ${textOf(error)}`);
  }

  private write(level: LogEntry["level"], text: string): void {
    const time = new Date().toISOString();
    const line: LogEntry = { type: "event", time, level, text, subject: "", count: 1 };
    this.page.patch({ log: withLines(this.page.get().log, [line]) });
  }
}
