import type { FromBrowser, FromServer } from "./types";

/** What the owner of a live socket wants to hear. */
export interface SocketListener {
  opened(): void;
  closed(): void;
  message(message: FromServer): void;
  binary(buffer: ArrayBuffer): void;
}

const FIRST_DELAY_MS = 100;
const LONGEST_DELAY_MS = 1000;
/** The server speaks at least once a second; a socket silent for longer than this is given up. */
const SILENCE_MS = 4000;
const CHECK_MS = 500;

/** A WebSocket that comes back by itself: waits 100 ms, doubling up to 1 s, between attempts. */
export class LiveSocket {
  private socket: WebSocket | null = null;
  private delay = FIRST_DELAY_MS;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private watch: ReturnType<typeof setInterval> | undefined;
  private heard = 0;
  private checkedAt = 0;
  private wanted = false;

  constructor(
    private readonly url: string,
    private readonly listener: SocketListener,
    private readonly open: (url: string) => WebSocket = (address) => new WebSocket(address),
  ) {}

  /** Connect, and stay connected until `stop`; a page has one live socket however often it signs in. */
  start(): void {
    if (this.wanted) return;
    this.wanted = true;
    this.delay = FIRST_DELAY_MS;
    this.watch = setInterval(() => {
      this.abandonIfSilent();
    }, CHECK_MS);
    this.connect();
  }

  stop(): void {
    this.wanted = false;
    clearTimeout(this.timer);
    clearInterval(this.watch);
    if (this.socket) this.leave(this.socket);
  }

  /** Connect anew, as another session: the one before ends. */
  restart(): void {
    this.stop();
    this.start();
  }

  /** True if the message was handed to the network. */
  send(message: FromBrowser): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private connect(): void {
    const socket = this.open(this.url);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.delay = FIRST_DELAY_MS;
      this.heard = performance.now();
      this.listener.opened();
    };
    socket.onmessage = (event: MessageEvent<ArrayBuffer | string>) => {
      this.heard = performance.now();
      if (typeof event.data === "string") this.listener.message(JSON.parse(event.data) as FromServer);
      else this.listener.binary(event.data);
    };
    socket.onclose = () => {
      this.lose(socket);
    };
    this.socket = socket;
  }

  /** A dead network never says so: drop the socket without waiting for its close event. */
  private abandonIfSilent(): void {
    const now = performance.now();
    const late = now - this.checkedAt > 3 * CHECK_MS;
    this.checkedAt = now;
    if (late) this.heard = now; // the page was busy: what the server said meanwhile has yet to be read
    if (this.socket?.readyState === WebSocket.OPEN && now - this.heard >= SILENCE_MS) this.lose(this.socket);
  }

  private lose(socket: WebSocket): void {
    this.leave(socket);
    if (this.wanted) this.retry();
  }

  /** Nothing that `socket` still says or does counts. */
  private leave(socket: WebSocket): void {
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this.socket = null;
    this.listener.closed();
  }

  private retry(): void {
    this.timer = setTimeout(() => {
      this.connect();
    }, this.delay);
    this.delay = Math.min(2 * this.delay, LONGEST_DELAY_MS);
  }
}

/** Address of a socket on the page's own origin. */
export function socketUrl({ protocol, host }: Pick<Location, "protocol" | "host">, path: string): string {
  return `${protocol === "https:" ? "wss" : "ws"}://${host}${path}`;
}
