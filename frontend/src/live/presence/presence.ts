/** Between two signs [ms]. */
export const SIGN_PERIOD_MS = 50;
/**
 * The worker gives no more signs once its page's main thread gave it none for so long: longer than the 2 s for which a
 * page may be busy on a loaded machine, by as much as a late answer takes there. 0.5 s later the rig holds.
 */
export const MAIN_SILENT_MS = 3000;
/** A socket that came about, or answered, no sooner is given up. */
const SOCKET_SILENT_MS = 2000;
/** Between two attempts to open one. */
const RETRY_MS = 100;

/** What the main thread says when it is asked: for which page signs are to be given, null for none. */
export type PageName = string | null;

/** An open presence socket, or one that is about to open. */
export interface SignSocket {
  readonly isOpen: boolean;
  send(text: string): void;
  close(): void;
}

/** What the signs need from outside, so that tests can hold clock and network. */
export interface PresencePort {
  now(): number;
  /** Ask the main thread for a sign; it answers by `answered`. */
  ask(): void;
  /** Open a socket for `page`; `heard` is called once it is open and for each answer, `closed` when it is gone. */
  open(page: string, heard: () => void, closed: () => void): SignSocket;
}

/** Signs of presence by a worker: for as long as its main thread answers, with patience for one that is busy. */
export class PresenceSigns {
  private page: PageName = null;
  private answeredAt = -Infinity;
  private asking = false;
  private socket: SignSocket | null = null;
  private openedFor: PageName = null;
  private triedAt = -Infinity;
  /** Since when the socket owes an answer: to being opened, or to the oldest sign that was not heard. */
  private owingSince: number | null = null;
  private n = 0;

  constructor(private readonly port: PresencePort) {}

  /** The main thread is there, and names its page. */
  answered(page: PageName): void {
    this.asking = false;
    this.answeredAt = this.port.now();
    this.page = page;
    if (page !== this.openedFor) this.drop();
  }

  /** Once per period. At most one question waits for a main thread that is busy. */
  tick(): void {
    if (!this.asking) {
      this.asking = true;
      this.port.ask();
    }
    const now = this.port.now();
    if (this.owingSince !== null && now - this.owingSince > SOCKET_SILENT_MS) this.drop();
    if (this.page === null) return;
    if (!this.socket) this.open(this.page, now);
    else if (this.socket.isOpen && now - this.answeredAt <= MAIN_SILENT_MS) this.sign(this.socket, now);
  }

  private sign(socket: SignSocket, now: number): void {
    this.n += 1;
    this.owingSince ??= now;
    socket.send(JSON.stringify({ type: "presence", n: this.n }));
  }

  private open(page: string, now: number): void {
    if (now - this.triedAt < RETRY_MS) return;
    this.triedAt = this.owingSince = now;
    this.openedFor = page;
    const socket: SignSocket = this.port.open(
      page,
      () => {
        if (this.socket === socket) this.owingSince = null;
      },
      () => {
        if (this.socket === socket) this.drop();
      },
    );
    this.socket = socket;
  }

  private drop(): void {
    const { socket } = this;
    this.socket = this.openedFor = this.owingSince = null;
    socket?.close();
  }
}
