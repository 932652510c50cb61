import { call } from "../api/rest";
import type { AlarmLimits } from "../api/types";
import type { Page } from "../live/page";
import type { Operations } from "../operate/operations";
import type { Store } from "../ui/store";

const PATH = "/api/alarms";

/** From where on the health figures are amber and red for me; kept on the server, and what it keeps is shown. */
export class Alarms {
  constructor(
    private readonly page: Store<Page>,
    private readonly operations: Operations,
  ) {}

  async learn(): Promise<void> {
    await this.take("Limits not known", () => call("GET", PATH));
  }

  async keep(title: string, limits: AlarmLimits): Promise<void> {
    await this.take(title, () => call("PUT", PATH, limits));
  }

  async reset(): Promise<void> {
    await this.take("Limits not reset", () => call("DELETE", PATH));
  }

  private async take(title: string, ask: () => Promise<AlarmLimits>): Promise<void> {
    await this.operations.attempt(title, async () => {
      this.page.patch({ alarms: await ask() });
    });
  }
}
