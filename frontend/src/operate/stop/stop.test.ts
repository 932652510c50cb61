import { expect, test } from "vitest";
import { Refusal, Unreachable } from "../../api/rest";
import type { CommandReply } from "../../api/types";
import { EMPTY_PAGE, type Page, type StopNews } from "../../live/page";
import { MODE } from "../../live/modes";
import { Store } from "../../ui/store";
import { EmergencyStop, watchLatch } from "./stop";

type Answer = (reply: CommandReply | Error) => void;

const TAKEN: CommandReply = { n: 1, accepted: true, mode: 6, cause: 1, detail: "" };
const SIGNED_OUT = new Refusal(401, "sign in first", true);

/** A page whose ways can be cut, on a clock that is set by hand. */
class FakePage {
  open = true;
  readonly sent: number[] = [];
  readonly asked: Answer[] = [];
  readonly written: string[] = [];
  news: StopNews | null = null;
  private now = 0;
  private timers: { at: number; action: () => void }[] = [];
  readonly stop = new EmergencyStop({
    bySocket: (n) => {
      if (this.open) this.sent.push(n);
      return this.open;
    },
    byHttp: () =>
      new Promise((resolve, reject) => {
        this.asked.push((reply) => {
          if (reply instanceof Error) reject(reply);
          else resolve(reply);
        });
      }),
    show: (news) => (this.news = news),
    write: (_, error) => this.written.push(String(error)),
    later: (action, delay) => this.timers.push({ at: this.now + delay, action }),
  });

  async pass(ms: number): Promise<void> {
    const end = this.now + ms;
    for (;;) {
      await settled();
      const due = this.timers.filter(({ at }) => at <= end).toSorted((a, b) => a.at - b.at)[0];
      if ((due as unknown) === undefined) break;
      this.now = due.at;
      this.timers = this.timers.filter((timer) => timer !== due);
      due.action();
    }
    this.now = end;
    await settled();
  }

  async http(reply: CommandReply | Error): Promise<void> {
    this.asked.shift()?.(reply);
    await settled();
  }
}

async function settled(): Promise<void> {
  for (let i = 0; i < 5; i++) await Promise.resolve();
}

test("a press goes both ways at once, and one that has arrived is enough", async () => {
  const page = new FakePage();
  page.stop.press();
  expect([page.sent, page.asked.length, page.news?.phase]).toEqual([[1], 1, "sent"]);
  page.stop.answered(1, "");
  expect(page.news).toEqual({ phase: "arrived", text: "E-STOP arrived at the rig" });
  await page.http(TAKEN);
  expect(page.news?.text).toBe("E-STOP arrived at the rig");
  await page.pass(5000);
  expect([page.sent, page.news]).toEqual([[1], null]);
});

test("without a cookie it arrives by the socket that is still open, and says why HTTP did not take it", async () => {
  const page = new FakePage();
  page.stop.press();
  await page.http(SIGNED_OUT);
  page.stop.answered(1, "");
  expect(page.news?.text).toBe("E-STOP arrived at the rig (web request: sign in first)");
  expect(page.written).toEqual([]);
});

test("without a socket it arrives by HTTP", async () => {
  const page = new FakePage();
  page.open = false;
  page.stop.press();
  await page.http(TAKEN);
  expect(page.news).toEqual({
    phase: "arrived",
    text: "E-STOP arrived at the rig (live connection: no connection)",
  });
});

test("where no way is left it says so, with the reasons, and goes on trying the one that may come back", async () => {
  const page = new FakePage();
  page.open = false;
  page.stop.press();
  await page.http(SIGNED_OUT);
  expect(page.news?.phase).toBe("lost");
  expect(page.news?.text).toContain(
    "use the hardware stop (live connection: no connection; web request: sign in first)",
  );
  expect(page.written).toHaveLength(1);
  page.open = true;
  await page.pass(600);
  expect([page.sent, page.asked]).toEqual([[1], []]);
  page.stop.answered(1, "");
  expect(page.news?.phase).toBe("arrived");
});

test("a server that cannot be reached is asked again every half second for 10 s, and it is logged once", async () => {
  const page = new FakePage();
  page.open = false;
  page.stop.press();
  for (let tries = 0; tries < 30; tries++) {
    await page.http(new Unreachable("no answer"));
    await page.pass(500);
  }
  expect([page.asked, page.written.length, page.news?.phase]).toEqual([[], 1, "lost"]);
  await page.pass(60_000);
  expect(page.news).toBeNull();
});

test("silence on both ways for a second is said, too", async () => {
  const page = new FakePage();
  page.stop.press();
  await page.pass(900);
  expect(page.news?.phase).toBe("sent");
  await page.pass(200);
  expect(page.news?.text).toContain("live connection: no answer yet; web request: no answer yet");
  expect(page.sent.length).toBeGreaterThan(1);
});

test("every press is an E-STOP of its own, and answers to an earlier one are not its own", () => {
  const page = new FakePage();
  page.stop.press();
  page.stop.answered(1, "");
  page.stop.press();
  expect(page.sent).toEqual([1, 2]);
  page.stop.answered(1, "");
  expect(page.news?.phase).toBe("sent");
  page.stop.answered(2, "");
  expect(page.news?.phase).toBe("arrived");
});

test("what has arrived is no news once the rig was cleared, whatever still answers", async () => {
  const page = new FakePage();
  page.stop.press();
  page.stop.answered(1, "");
  page.stop.cleared();
  expect(page.news).toBeNull();
  await page.http(TAKEN);
  await page.pass(60_000);
  expect(page.news).toBeNull();
  page.stop.press();
  page.stop.answered(page.sent.at(-1) ?? 0, "");
  expect(page.news?.phase).toBe("arrived");
});

test("a clear of an earlier E-STOP does not silence one that has not arrived", async () => {
  const page = new FakePage();
  page.stop.press();
  page.stop.cleared();
  expect(page.news?.phase).toBe("sent");
  await page.http(TAKEN);
  expect(page.news?.phase).toBe("arrived");
});

test("the rig has left E-STOP when its mode says so, not when it is silent", () => {
  const page = new Store<Page>({ ...EMPTY_PAGE, mode: MODE.HOLD });
  let times = 0;
  watchLatch({ cleared: () => (times += 1) }, page);
  const seen = [MODE.E_STOP, null, MODE.E_STOP, MODE.VENTED, MODE.HOLD].map((mode) => {
    page.patch({ mode });
    return times;
  });
  expect(seen).toEqual([0, 0, 0, 1, 1]);
});
