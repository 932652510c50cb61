import { expect, test } from "vitest";
import { MAIN_SILENT_MS, SIGN_PERIOD_MS, PresenceSigns, type PageName } from "./presence";

/** Clock, main thread and network in the test's hand. */
class World {
  now = 0;
  page: PageName = "a";
  mainBusy = false;
  serverSilent = false;
  refused = false;
  /** Times of the signs that went out, and for which page. */
  readonly signs: { at: number; page: string; n: number }[] = [];
  asked = 0;
  sockets = 0;
  open = 0;
  private waiting = false;
  readonly signer = new PresenceSigns({
    now: () => this.now,
    ask: () => {
      this.asked += 1;
      this.waiting = true;
    },
    open: (page, heard, closed) => {
      this.sockets += 1;
      this.open += 1;
      const socket = { isOpen: !this.refused, closed: false };
      if (this.refused) {
        this.open -= 1;
        queueMicrotask(closed);
      } else if (!this.serverSilent) queueMicrotask(heard);
      return {
        get isOpen() {
          return socket.isOpen;
        },
        send: (text: string) => {
          this.signs.push({ at: this.now, page, n: (JSON.parse(text) as { n: number }).n });
          if (!this.serverSilent) heard();
        },
        close: () => {
          if (!socket.closed && socket.isOpen) this.open -= 1;
          socket.closed = true;
        },
      };
    },
  });

  async run(ms: number): Promise<void> {
    const end = this.now + ms;
    for (; this.now < end; this.now += SIGN_PERIOD_MS) {
      if (this.waiting && !this.mainBusy) {
        this.waiting = false;
        this.signer.answered(this.page);
      }
      this.signer.tick();
      await Promise.resolve();
    }
  }

  longestGap(from: number): number {
    const times = this.signs.map(({ at }) => at).filter((at) => at >= from);
    return Math.max(...times.slice(1).map((at, i) => at - times[i]));
  }
}

test("signs go on through 2 s of a busy main thread, which is asked only once meanwhile", async () => {
  const world = new World();
  await world.run(1000);
  const asked = world.asked;
  world.mainBusy = true;
  await world.run(2000);
  expect(world.asked - asked).toBeLessThanOrEqual(1);
  world.mainBusy = false;
  await world.run(1000);
  expect(world.longestGap(500)).toBe(SIGN_PERIOD_MS);
});

test("a main thread that is hung for ever ends them after the bound, and one that comes back begins again", async () => {
  const world = new World();
  await world.run(1000);
  world.mainBusy = true;
  await world.run(20_000);
  const last = world.signs.at(-1)?.at ?? NaN;
  expect(last - 1000).toBeGreaterThan(MAIN_SILENT_MS - 2 * SIGN_PERIOD_MS);
  expect(last - 1000).toBeLessThanOrEqual(MAIN_SILENT_MS);
  world.mainBusy = false;
  await world.run(200);
  expect(world.signs.at(-1)?.at).toBeGreaterThan(21_000);
});

test("who does not operate, or left, gives none, and has no socket", async () => {
  const world = new World();
  world.page = null;
  await world.run(1000);
  expect([world.signs.length, world.sockets]).toEqual([0, 0]);
  world.page = "a";
  await world.run(1000);
  world.page = null;
  await world.run(1000);
  expect(world.signs.at(-1)?.at).toBeLessThan(2000 + 2 * SIGN_PERIOD_MS);
  expect(world.open).toBe(0);
});

test("another name of the page means another socket, and numbers go on rising", async () => {
  const world = new World();
  await world.run(500);
  world.page = "b";
  await world.run(500);
  expect(world.signs.at(-1)?.page).toBe("b");
  expect(world.open).toBe(1);
  const numbers = world.signs.map(({ n }) => n);
  expect(numbers).toEqual(numbers.toSorted((a, b) => a - b));
  expect(new Set(numbers).size).toBe(numbers.length);
});

test("a socket that is refused or falls silent is tried again, one at a time", async () => {
  const world = new World();
  world.refused = true;
  await world.run(1000);
  expect(world.sockets).toBeGreaterThan(3);
  expect(world.sockets).toBeLessThanOrEqual(11);
  world.refused = false;
  await world.run(500);
  expect(world.signs.length).toBeGreaterThan(3);
  const before = world.sockets;
  world.serverSilent = true;
  await world.run(7000);
  expect(world.sockets - before).toBeGreaterThanOrEqual(2);
  expect(world.open).toBe(1);
  world.serverSilent = false;
  await world.run(3000);
  expect(world.longestGap(8500)).toBeLessThanOrEqual(3 * SIGN_PERIOD_MS);
});
