import { api, dataOf } from "../api/rest";
import type { AlarmLimits } from "../api/types";
import type { Page } from "../live/page";
import type { Operations } from "../operate/operations";
import type { Store } from "../ui/store";

/** Where limits are kept: the server, or a test. */
const server = {
  read: () => dataOf(api.GET("/api/alarms")),
  keep: (body: AlarmLimits) => dataOf(api.PUT("/api/alarms", { body })),
  reset: () => dataOf(api.DELETE("/api/alarms")),
};

/** From where on the health figures are amber and red for me; kept on the server, and what it keeps is shown. */
export class Alarms {
  constructor(
    private readonly page: Store<Page>,
    private readonly operations: Pick<Operations, "attemptInTurn">,
    private readonly port = server,
  ) {}

  async learn(): Promise<void> {
    await this.take("Limits not known", this.port.read);
  }

  /** Change them, once every change before is done: each begins with what the last one left in force. */
  async keep(title: string, change: (now: AlarmLimits) => AlarmLimits): Promise<void> {
    await this.take(title, () => {
      const now = this.page.get().alarms;
      return now ? this.port.keep(change(now)) : this.port.read();
    });
  }

  async reset(): Promise<void> {
    await this.take("Limits not reset", this.port.reset);
  }

  private async take(title: string, asked: () => Promise<AlarmLimits>): Promise<void> {
    await this.operations.attemptInTurn(title, async () => {
      this.page.patch({ alarms: await asked() });
    });
  }
}
