import { expect, test, vi } from "vitest";
import { api } from "../api/rest";
import type { LiveSocket, SocketListener } from "../api/socket";
import type { FromServer, Lease } from "../api/types";
import { Connection, type ConnectionListener } from "./connection";
import type { Live } from "./live";
import { PageStore } from "./page";

const MINE: Lease = { held: true, mine: true, holder: "ivy", clutch: false };
const FREE: Lease = { held: false, mine: false, holder: "", clutch: false };

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
  const listener = { leaseChanged: vi.fn(), leaseLost: vi.fn(), failed: vi.fn(), met: vi.fn() };
  const live = { describe: vi.fn(), choice: () => ({}) };
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
  return { page, listener, say, status };
}

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
  expect(listener.leaseChanged).toHaveBeenCalledWith(false, "");
});

test("another server's clock begins again", async () => {
  const { page, say, status } = connected();
  await answered(1e6);
  const session = { name: "ivy", role: "operator", unprotected: false, lease: FREE };
  say({ type: "hello", page: "p", session, layout: {}, channels: [], log: [], rig: null });
  status(0.5, MINE);
  expect(page.get().lease).toEqual(MINE);
});
