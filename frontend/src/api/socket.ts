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

/** A WebSocket that comes back by itself: waits 100 ms, doubling up to 1 s, between attempts. */
export class LiveSocket {
  private socket: WebSocket | null = null;
  private delay = FIRST_DELAY_MS;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private watch: ReturnType<typeof setInterval> | undefined;
  private heard = 0;
  private wanted = false;

  constructor(
    private readonly url: string,
    private readonly listener: SocketListener,
  ) {}

  start(): void {
    this.wanted = true;
    this.watch = setInterval(() => {
      this.abandonIfSilent();
    }, 500);
    this.connect();
  }

  stop(): void {
    this.wanted = false;
    clearTimeout(this.timer);
    clearInterval(this.watch);
    this.socket?.close();
  }

  /** True if the message was handed to the network. */
  send(message: FromBrowser): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private connect(): void {
    const socket = new WebSocket(this.url);
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
      this.lost();
    };
    this.socket = socket;
  }

  /** A dead network never says so: drop the socket without waiting for its close event. */
  private abandonIfSilent(): void {
    const socket = this.socket;
    if (socket?.readyState !== WebSocket.OPEN || performance.now() - this.heard < SILENCE_MS) return;
    socket.onclose = socket.onmessage = null;
    socket.close();
    this.lost();
  }

  private lost(): void {
    this.listener.closed();
    if (this.wanted) this.retry();
  }

  private retry(): void {
    this.timer = setTimeout(() => {
      this.connect();
    }, this.delay);
    this.delay = Math.min(2 * this.delay, LONGEST_DELAY_MS);
  }
}

/** Address of the live socket on the page's own origin. */
export function liveUrl(location: Location): string {
  return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws/live`;
}
