import { beforeEach, expect, test, vi } from "vitest";
import { LiveSocket } from "./socket";

class Fake {
  static readonly all: Fake[] = [];
  readyState = 0;
  binaryType = "";
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: (() => void) | null = null;
  readonly sent: string[] = [];
  constructor() {
    Fake.all.push(this);
  }
  send = (text: string) => void this.sent.push(text);
  /** The close event comes later, as in a browser. */
  close(): void {
    if (this.readyState >= 2) return;
    this.readyState = 2;
    setTimeout(() => {
      this.end();
    }, 20);
  }
  end(): void {
    this.readyState = 3;
    this.onclose?.();
  }
  opened(): void {
    this.readyState = 1;
    this.onopen?.();
  }
}

let closed = 0;
let messages: string[] = [];

function socketOf(): LiveSocket {
  const socket = new LiveSocket("ws://here/ws/live", () => new Fake() as unknown as WebSocket);
  socket.tell({
    opened: () => undefined,
    closed: () => (closed += 1),
    message: (message) => messages.push(message.type),
    binary: () => undefined,
  });
  return socket;
}

const alive = () => Fake.all.filter(({ readyState }) => readyState < 2);

beforeEach(() => {
  vi.stubGlobal("WebSocket", { OPEN: 1 });
  vi.useFakeTimers({ toFake: ["setTimeout", "setInterval", "clearTimeout", "clearInterval", "performance"] });
  Fake.all.length = closed = 0;
  messages = [];
});

test("signing in twice leaves one live socket, and one that comes back is one again", () => {
  const socket = socketOf();
  socket.start();
  socket.start();
  expect(alive()).toHaveLength(1);
  Fake.all[0].opened();
  socket.start();
  Fake.all[0].end();
  vi.advanceTimersByTime(5000);
  expect(alive()).toHaveLength(1);
  expect(closed).toBe(1);
});

test("signed out and in again at once there is one socket, and what the old one still does counts for nothing", () => {
  const socket = socketOf();
  socket.start();
  const [old] = Fake.all;
  old.opened();
  const hear = old.onmessage;
  socket.stop();
  socket.start();
  vi.advanceTimersByTime(5000);
  expect(alive()).toHaveLength(1);
  expect(closed).toBe(1);
  expect(hear).not.toBeNull();
  expect(old.onmessage).toBeNull();
});

test("signed out while it waits to try again, nothing is opened any more", () => {
  const socket = socketOf();
  socket.start();
  Fake.all[0].end();
  socket.stop();
  vi.advanceTimersByTime(5000);
  expect(alive()).toHaveLength(0);
});

test("another session means another socket", () => {
  const socket = socketOf();
  socket.start();
  Fake.all[0].opened();
  socket.restart();
  vi.advanceTimersByTime(5000);
  expect(Fake.all).toHaveLength(2);
  expect(alive()).toEqual([Fake.all[1]]);
});

test("a socket that never opens is given up, and the next one is tried", () => {
  const socket = socketOf();
  socket.start();
  vi.advanceTimersByTime(7000);
  expect(Fake.all).toHaveLength(1);
  vi.advanceTimersByTime(2000);
  expect(alive()).toEqual([Fake.all[1]]);
  Fake.all[1].opened();
  vi.advanceTimersByTime(1000);
  expect(alive()).toEqual([Fake.all[1]]);
});
