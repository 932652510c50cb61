import type { FromBrowser, FromServer } from "./types";

/** What the owner of a live socket wants to hear. */
export interface SocketListener {
  opened(): void;
  closed(): void;
  message(message: FromServer): void;
  binary(buffer: ArrayBuffer): void;
}

const FIRST_DELAY_MS = 100;
const RETRY_DELAY_MAX_MS = 1000;
/** The server speaks at least once a second; a socket silent for longer than this is given up. */
const SILENCE_MS = 4000;
/** One that does not open in this time is given up, too: whatever lies between may answer the next. */
const OPENING_MS = 8000;
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
  private listener: SocketListener | null = null;

  constructor(
    private readonly url: string,
    private readonly open: (url: string) => WebSocket = (address) => new WebSocket(address),
  ) {}

  /** Tell `listener` from now on. */
  tell(listener: SocketListener): void {
    this.listener = listener;
  }

  /** Connect, and stay connected until `stop`; a page has one live socket however often it signs in. */
  start(): void {
    if (this.wanted) return;
    this.wanted = true;
    this.delay = FIRST_DELAY_MS;
    this.watch = setInterval(() => this.abandonIfSilent(), CHECK_MS);
    this.connect();
  }

  stop(): void {
    this.wanted = false;
    clearTimeout(this.timer);
    clearInterval(this.watch);
    if (this.socket) this.leave(this.socket);
  }

  /** Connect again, as another session: the one before ends. */
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
    this.heard = performance.now();
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.delay = FIRST_DELAY_MS;
      this.heard = performance.now();
      this.listener?.opened();
    };
    socket.onmessage = (event: MessageEvent<ArrayBuffer | string>) => {
      this.heard = performance.now();
      if (typeof event.data === "string") this.listener?.message(JSON.parse(event.data) as FromServer);
      else this.listener?.binary(event.data);
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
    if (!this.socket) return;
    const patience = this.socket.readyState === WebSocket.OPEN ? SILENCE_MS : OPENING_MS;
    if (now - this.heard >= patience) this.lose(this.socket);
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
    this.listener?.closed();
  }

  private retry(): void {
    this.timer = setTimeout(() => this.connect(), this.delay);
    this.delay = Math.min(2 * this.delay, RETRY_DELAY_MAX_MS);
  }
}

/** Address of a socket on the page's own origin. */
export function socketUrl({ protocol, host }: Pick<Location, "protocol" | "host">, path: string): string {
  return `${protocol === "https:" ? "wss" : "ws"}://${host}${path}`;
}

/** The page and the server disagree about a record. */
export class LayoutError extends Error {}

/** First word of a binary message (server/plots/messages.py, `Kind`). */
const KIND = { FRAME: 1, PLOT: 2 } as const;
const HEADER = 8;
const PLOT_HEADER = 16;

/** Extremes of every 1 kHz sample in the bins `first`, `first` + 1, ...: `low` and `high` are [bin][channel]. */
export interface PlotBins {
  readonly first: number;
  /** Places of the channels in `Hello.channels`. */
  readonly channels: Uint32Array;
  readonly t: Float64Array;
  readonly low: Float32Array;
  readonly high: Float32Array;
}

export type Binary = { kind: "frame"; offset: number } | { kind: "plot"; bins: PlotBins };

/** Say what a binary message holds; plot bins are views into `buffer`, nothing is copied. */
export function decodeBinary(buffer: ArrayBuffer): Binary {
  if (buffer.byteLength < HEADER)
    throw new LayoutError(`a binary message of ${buffer.byteLength} bytes has no header`);
  const head = new DataView(buffer, 0, HEADER);
  const kind = head.getUint32(0, true);
  switch (kind) {
    case KIND.FRAME:
      return { kind: "frame", offset: HEADER };
    case KIND.PLOT:
      return { kind: "plot", bins: plotBins(buffer) };
    default:
      throw new LayoutError(`unknown kind ${kind} of binary message`);
  }
}

function plotBins(buffer: ArrayBuffer): PlotBins {
  const [, count, width, first] =
    buffer.byteLength < PLOT_HEADER ? [0, NaN, NaN, 0] : new Uint32Array(buffer, 0, 4);
  const channels = PLOT_HEADER + 8 * count;
  const low = channels + 4 * width;
  const samples = count * width;
  if (buffer.byteLength !== low + 8 * samples)
    throw new LayoutError(
      `a plot message of ${buffer.byteLength} bytes does not fit ${count} bins of ${width} channels`,
    );
  return {
    first,
    channels: new Uint32Array(buffer, channels, width),
    t: new Float64Array(buffer, PLOT_HEADER, count),
    low: new Float32Array(buffer, low, samples),
    high: new Float32Array(buffer, low + 4 * samples, samples),
  };
}
