import { api, dataOf } from "../../api/rest";
import { keep, type Page } from "../../live/page";
import { textOf } from "../../ui/format";
import { Store } from "../../ui/store";
import { Jog } from "./jog";
import type { Chamber, CommissioningState, Place, StartBody, StepName } from "./steps";

interface Commissioned {
  /** Null before it is known, and of a rig that is a twin. */
  readonly state: CommissioningState | null;
  /** The chamber whose button is held here. */
  readonly held: Chamber | null;
  /** The operator has said that no one reaches into the arm. */
  readonly clear: boolean;
  /** What the server was asked last and did not do. */
  readonly refusal: string;
  /** What is being asked now. */
  readonly asking: string;
}

/** The rig is made of devices, and has a rig file. */
export function isHardware({ rig }: Pick<Page, "rig">): boolean {
  return rig !== null && !rig.twin && rig.parameters.hardware !== null;
}

/** The commissioning as the page has it: where it stands, and what its operator asks for. */
export class Commissioning {
  readonly store = new Store<Commissioned>({
    state: null,
    held: null,
    clear: false,
    refusal: "",
    asking: "",
  });
  readonly jog = new Jog({
    send: async (chamber) => {
      const how: RequestInit = { priority: "high", keepalive: chamber === null };
      await this.take(api.PUT("/api/commissioning/jog", { ...how, body: { chamber } }));
    },
    every: (action, period) => setInterval(action, period),
    show: (held) => this.store.patch({ held }),
    failed: (error) => this.store.patch({ refusal: textOf(error) }),
  });
  /** Requests are numbered: an answer that was overtaken by one to a later request is old. */
  private asked = 0;
  private answered = 0;

  constructor(private readonly page: Store<Page>) {}

  /** Where it stands now; a twin has none. */
  async learn(): Promise<void> {
    if (!isHardware(this.page.get())) {
      this.store.patch({ state: null });
      return;
    }
    await this.take(api.GET("/api/commissioning"));
  }

  /** The operator has said that no one reaches into the arm. */
  confirmClear(): void {
    this.store.patch({ clear: true });
  }

  async start(step: StepName, body: StartBody): Promise<void> {
    await this.ask(`start ${step}`, api.POST("/api/commissioning/{step}/start", { ...at(step), body }));
  }

  async stop(step: StepName): Promise<void> {
    await this.ask(`stop ${step}`, api.POST("/api/commissioning/{step}/stop", at(step)));
  }

  async accept(step: StepName): Promise<void> {
    await this.ask(`accept ${step}`, api.POST("/api/commissioning/{step}/accept", at(step)));
  }

  /** Forget what a step came to, and what rests on it. */
  async back(step: StepName): Promise<void> {
    await this.ask(`back ${step}`, api.POST("/api/commissioning/{step}/back", at(step)));
  }

  async confirm(commanded: Chamber, filled: Chamber): Promise<void> {
    await this.ask("confirm", api.PUT("/api/commissioning/jog/confirm", { body: { commanded, filled } }));
  }

  async capture(place: Place, point: string | null): Promise<void> {
    await this.ask(
      `capture ${place}`,
      api.PUT("/api/commissioning/frame/capture", { body: { place, point } }),
    );
  }

  /** A refusal stands where it was asked until the next request. */
  private async ask(asking: string, asked: Promise<{ data?: CommissioningState }>): Promise<void> {
    this.store.patch({ asking, refusal: "" });
    try {
      await this.take(asked);
    } catch (error) {
      this.store.patch({ refusal: textOf(error) });
    } finally {
      this.store.patch({ asking: "" });
    }
  }

  private async take(asked: Promise<{ data?: CommissioningState }>): Promise<void> {
    const number = (this.asked += 1);
    const state = await dataOf(asked);
    if (number < this.answered) return;
    this.answered = number;
    this.store.patch({ state: keep(this.store.get().state, state) });
  }
}

const at = (step: StepName) => ({ params: { path: { step } } });
