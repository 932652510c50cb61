import { expect, test, vi } from "vitest";
import { api } from "../../api/rest";
import { EMPTY_PAGE, type Page } from "../../live/page";
import { MODE } from "../../live/modes";
import { Store } from "../../ui/store";
import { Operations } from "../operations";
import { TwinTime } from "./twinTime";

const HEALTH: Page["health"] = {
  ...{
    rig_connected: true,
    rig_age: 0,
    link_rtt: 0,
    viewers: 1,
    trouble: "",
    starting: "",
    on_time: null,
    lost: null,
    energy_balance: null,
    server: "",
  },
  paused: false,
};

function made(twin: boolean) {
  const asked: unknown[] = [];
  vi.spyOn(api, "PUT").mockImplementation(((path: string, options: { body: unknown }) => {
    asked.push([path, options.body]);
    return Promise.resolve({});
  }) as never);
  const page = new Store<Page>({
    ...EMPTY_PAGE,
    ...{ online: true, rigLive: true, mode: MODE.HOLD, health: HEALTH },
    rig: { twin, parameters: {} } as Page["rig"],
    lease: { ...EMPTY_PAGE.lease, held: true, mine: true },
  });
  const time = new TwinTime(page, new Operations(page, () => undefined));
  return { time, page, asked };
}

test("the key pauses, and then lets the twin go on", async () => {
  const { time, page, asked } = made(true);
  await time.toggle();
  page.patch({ health: { ...HEALTH, paused: true } });
  await time.toggle();
  expect(asked).toEqual([
    ["/api/twin/time", { paused: true, steps: 0 }],
    ["/api/twin/time", { paused: false, steps: 0 }],
  ]);
});

test("a step has the chosen length, and is nothing where the twin goes on", async () => {
  const { time, page, asked } = made(true);
  await time.step();
  expect(asked).toEqual([]);
  page.patch({ step: 100, health: { ...HEALTH, paused: true } });
  await time.step();
  expect(asked).toEqual([["/api/twin/time", { paused: true, steps: 100 }]]);
});

test("hardware's time is never asked to stand still", async () => {
  const { time, asked } = made(false);
  await time.toggle();
  await time.step();
  expect(asked).toEqual([]);
});
