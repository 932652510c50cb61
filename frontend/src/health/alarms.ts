import { api, dataOf } from "../api/rest";
import type { AlarmLimits } from "../api/types";
import type { Page } from "../live/page";
import type { Operations } from "../operate/operations";
import type { Store } from "../ui/store";

/** From where on the health figures are amber and red for me; kept on the server, and what it keeps is shown. */
export class Alarms {
  constructor(
    private readonly page: Store<Page>,
    private readonly operations: Operations,
  ) {}

  async learn(): Promise<void> {
    await this.take("Limits not known", api.GET("/api/alarms"));
  }

  async keep(title: string, limits: AlarmLimits): Promise<void> {
    await this.take(title, api.PUT("/api/alarms", { body: limits }));
  }

  async reset(): Promise<void> {
    await this.take("Limits not reset", api.DELETE("/api/alarms"));
  }

  private async take(title: string, asked: Promise<{ data?: AlarmLimits }>): Promise<void> {
    await this.operations.attempt(title, async () => {
      this.page.patch({ alarms: await dataOf(asked) });
    });
  }
}
