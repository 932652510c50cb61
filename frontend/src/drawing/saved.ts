import { api, named, dataOf } from "../api/rest";
import type { DrawingInfo } from "../api/types";
import type { Operations } from "../operate/operations";
import { Store } from "../ui/store";
import { bodyOf, type Drawing } from "./drawing";

/** Address of the saved drawing `name` as a file. */
export function drawingUrl(name: string): string {
  return `/api/drawings/${encodeURIComponent(name)}.csv`;
}

/** The drawings kept by the server. */
export class SavedDrawings {
  readonly store = new Store<{ readonly list: readonly DrawingInfo[] }>({ list: [] });

  constructor(
    private readonly drawing: Drawing,
    private readonly operations: Pick<Operations, "attempt">,
  ) {}

  async learn(): Promise<void> {
    await this.operations.attempt("Drawings not listed", async () => {
      this.store.patch({ list: await dataOf(api.GET("/api/drawings")) });
    });
  }

  /** Keep the drawing under its name; one of that name is replaced. */
  async save(): Promise<void> {
    const body = bodyOf(this.drawing.store.get());
    if (!body) return;
    await this.operations.attempt("Drawing not saved", () =>
      api.PUT("/api/drawings/{name}", { ...named(body.name), body }),
    );
    await this.learn();
  }

  async load(name: string): Promise<void> {
    await this.operations.attempt("Drawing not loaded", async () => {
      this.drawing.load(await dataOf(api.GET("/api/drawings/{name}", named(name))));
    });
  }

  async remove(name: string): Promise<void> {
    await this.operations.attempt("Drawing not deleted", () =>
      api.DELETE("/api/drawings/{name}", named(name)),
    );
    await this.learn();
  }
}
