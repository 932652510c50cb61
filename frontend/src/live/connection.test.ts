import { afterEach, expect, test, vi } from "vitest";
import { api } from "../api/rest";
import type { LiveSocket, SocketListener } from "../api/socket";
import type { FromServer, Health, Lease } from "../api/types";
import { Connection, type ConnectionListener } from "./connection";
import { Live, RoundTrip } from "./live";
import { PageStore, silenceOf } from "./page";

const MINE: Lease = { held: true, mine: true, holder: "ivy", clutch: false, lost: "" };
const FREE: Lease = { held: false, mine: false, holder: "", clutch: false, lost: "control was released" };

/** A connection whose socket says what the test has it say. */
function connected() {
  const page = new PageStore();
  const heard: { socket: SocketListener | null } = { socket: null };
  const socket = {
    tell: (listener: SocketListener) => {
      heard.socket = listener;
    },
    send: vi.fn(),
  };
  const listener = { leaseChanged: vi.fn(), failed: vi.fn(), met: vi.fn() };
  const live = {
    describe: vi.fn(),
    choice: () => ({}),
    roundTrip: new RoundTrip(),
    freshAt: 0,
    telemetry: { at: () => 0, point: () => null },
    take: (_: ArrayBuffer, now: number) => {
      live.freshAt = now;
      return true;
    },
  };
  new Connection(
    live as unknown as Live,
    page,
    socket as unknown as LiveSocket,
    listener as unknown as ConnectionListener,
  );
  const say = (message: object) => heard.socket?.message(message as FromServer);
  const status = (read_at: number, lease: Lease) => {
    say({ type: "status", read_at, lease, recording: page.get().recording, health: {}, rig: null });
  };
  const show = () => heard.socket?.binary(new ArrayBuffer(1));
  return { page, listener, say, status, show };
}

test("the first picture says that the rig is there, before the next look at the clock", () => {
  const { page, show } = connected();
  page.patch({ online: true });
  show();
  expect([page.get().mode, silenceOf(page.get())]).toEqual([0, "none"]);
  const { page: other, show: showOther } = connected();
  other.patch({ online: true, health: { rig_connected: false } as Health });
  showOther();
  expect(silenceOf(other.get())).toBe("rig");
});

/** An answer to a request for a change, given at `time`. */
async function answered(time: number): Promise<void> {
  vi.stubGlobal("fetch", () =>
    Promise.resolve(Response.json(MINE, { headers: { "tendril-time": `${time}` } })),
  );
  await api.POST("/api/lease", { baseUrl: "http://rig" });
}

test("a status that was read before an answer takes nothing back when it comes after it", async () => {
  const { page, listener, status } = connected();
  await answered(7.5);
  page.patch({ lease: MINE });
  status(7.4, FREE);
  expect(page.get().lease).toEqual(MINE);
  expect(listener.leaseChanged).not.toHaveBeenCalled();
  status(7.6, FREE);
  expect(page.get().lease).toEqual(FREE);
  expect(listener.leaseChanged).toHaveBeenCalledWith(FREE, "");
});

test("another server's clock begins again", async () => {
  const { page, say, status } = connected();
  await answered(1e6);
  const session = { name: "ivy", role: "operator", unprotected: false, lease: FREE };
  say({ type: "hello", page: "p", session, layout: {}, channels: [], log: [], rig: null });
  status(0.5, MINE);
  expect(page.get().lease).toEqual(MINE);
});

/** A page that was live at 0 s, on a clock and a network of the test. */
async function lived() {
  vi.useFakeTimers({ toFake: ["setInterval", "setTimeout", "performance"] });
  vi.stubGlobal("Worker", class { postMessage() {} }); // prettier-ignore
  vi.stubGlobal("window", { addEventListener: vi.fn() });
  vi.stubGlobal("document", { addEventListener: vi.fn() });
  vi.stubGlobal("fetch", () => Promise.reject(new TypeError("no network")));
  const page = new PageStore();
  const live = new Live();
  const network = { isUp: true };
  const heard: { socket: SocketListener | null } = { socket: null };
  const socket = {
    tell: (listener: SocketListener) => {
      heard.socket = listener;
    },
    send: (message: { type: string; t: number }) => {
      const pong = () => heard.socket?.message({ type: "pong", t: message.t });
      if (message.type === "ping" && network.isUp) setTimeout(pong, 14);
      return true;
    },
  };
  const connection = new Connection(
    live,
    page,
    socket as unknown as LiveSocket,
    { disconnected: vi.fn() } as unknown as ConnectionListener,
  );
  void connection.start();
  heard.socket?.opened();
  page.patch({ health: { rig_connected: true, paused: false } as Health });
  const until = async (ms: number, pictures: boolean) => {
    while (performance.now() < ms) {
      if (pictures) {
        live.freshAt = performance.now();
        heard.socket?.binary(new ArrayBuffer(0));
      }
      await vi.advanceTimersByTimeAsync(50);
    }
  };
  const start = performance.now();
  await until(start + 3000, true);
  return { page, live, network, until, start: start + 3000 };
}

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("a network that is lost is no rig that is lost, from the first second on", async () => {
  const { page, live, network, until, start } = await lived();
  expect([silenceOf(page.get()), live.roundTrip.took]).toEqual(["none", 0.014]);
  network.isUp = false;
  const said = new Set<string>();
  page.subscribe(() => said.add(silenceOf(page.get())));
  await until(start + 1500, false);
  expect([...said]).toEqual(["server"]);
  expect(live.roundTrip.at(performance.now())).toBeGreaterThan(0.5);
});

test("where the server still answers it is the rig that is silent", async () => {
  const { page, until, start } = await lived();
  const said = new Set<string>();
  page.subscribe(() => said.add(silenceOf(page.get())));
  await until(start + 3000, false);
  expect([...said]).toEqual(["rig"]);
  expect(page.get().unheard).toBe(false);
});
