import type { Page } from "../../live/page";
import { MODE, MODE_WORD, whyText } from "../../live/modes";
import { quietly, type PageStorage } from "../../ui/storage";
import { Store } from "../../ui/store";

const KEY = "tendril-notices";

/** What the browser lets this page do; "missing" where it has no notifications, or not at an address without https. */
export type Leave = NotificationPermission | "missing";

/** The browser's notifications, and whether anyone looks at the page. */
export interface Desk {
  leave(): Leave;
  /** Ask the person; only upon a click. */
  ask(): Promise<Leave>;
  show(title: string, text: string): void;
  away(): boolean;
}

export interface NoticesState {
  readonly wanted: boolean;
  readonly leave: Leave;
}

/** Tells of FAULT, E-STOP and the end of a run by the browser's own notifications, where no one looks at the page. */
export class Notices {
  readonly store: Store<NoticesState>;
  private mode: Page["mode"] = null;
  /** Of the last run that ended; undefined before the server said so. */
  private run: number | null | undefined = undefined;

  constructor(
    private readonly page: Store<Page>,
    private readonly storage: PageStorage,
    private readonly desk: Desk = browser,
  ) {
    const wanted = quietly(() => storage.getItem(KEY)) === "on";
    this.store = new Store<NoticesState>({ wanted, leave: desk.leave() });
    page.subscribe(() => {
      this.look();
    });
  }

  /** Switched by a click: the first time the browser asks. */
  async want(wanted: boolean): Promise<void> {
    const leave = wanted && this.desk.leave() === "default" ? await this.desk.ask() : this.desk.leave();
    this.store.patch({ wanted: wanted && leave === "granted", leave });
    quietly(() => {
      this.storage.setItem(KEY, this.store.get().wanted ? "on" : "off");
    });
  }

  /** Show one now, though someone looks. */
  test(): void {
    this.desk.show("Tendril: test", "FAULT, E-STOP and the end of a run are told like this.");
  }

  private look(): void {
    const { mode, result, settings } = this.page.get();
    const before = this.mode;
    this.mode = mode;
    if (before !== null && mode !== before && (mode === MODE.FAULT || mode === MODE.E_STOP))
      this.tell(MODE_WORD[mode], whyText(this.page.get()));
    if (settings === null) return; // the server has said nothing yet
    const ended = this.run;
    this.run = result?.id ?? null;
    if (ended !== undefined && result && result.id !== ended)
      this.tell(`${result.name} ${result.state}`, result.reason);
  }

  private tell(what: string, why: string): void {
    if (this.store.get().wanted && this.desk.leave() === "granted" && this.desk.away())
      this.desk.show(`Tendril: ${what}`, why);
  }
}

const browser: Desk = {
  leave: () => ("Notification" in window && window.isSecureContext ? Notification.permission : "missing"),
  ask: () => Notification.requestPermission(),
  show: (title, body) => {
    const shown = new Notification(title, { body });
    shown.onclick = () => {
      window.focus();
      shown.close();
    };
  },
  away: () => document.hidden || !document.hasFocus(),
};
