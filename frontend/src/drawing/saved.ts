import { call } from "../api/rest";
import type { DrawingBody, DrawingInfo } from "../api/types";
import type { Operations } from "../operate/operations";
import { Store } from "../ui/store";
import { bodyOf, type Drawing } from "./drawing";

const DRAWINGS = "/api/drawings";

/** Address of the saved drawing `name`; with ".csv" behind it, of its download. */
export function drawingUrl(name: string): string {
  return `${DRAWINGS}/${encodeURIComponent(name)}`;
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
      this.store.patch({ list: await call("GET", DRAWINGS) });
    });
  }

  /** Keep the drawing under its name; one of that name is replaced. */
  async save(): Promise<void> {
    const body = bodyOf(this.drawing.store.get());
    if (!body) return;
    await this.operations.attempt("Drawing not saved", () => call("PUT", drawingUrl(body.name), body));
    await this.learn();
  }

  async load(name: string): Promise<void> {
    await this.operations.attempt("Drawing not loaded", async () => {
      this.drawing.load(await call<DrawingBody>("GET", drawingUrl(name)));
    });
  }

  async remove(name: string): Promise<void> {
    await this.operations.attempt("Drawing not deleted", () => call("DELETE", drawingUrl(name)));
    await this.learn();
  }
}
