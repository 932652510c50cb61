import type { DrawingBody, DrawingInfo } from "../api/types";
import { bodyOf, type Drawing } from "./drawing";
import type { Operations } from "../operate/operations";
import { Store } from "../ui/store";

/** Where drawings are kept, so that tests can answer. */
export interface DrawingKeeper {
  drawings(): Promise<DrawingInfo[]>;
  drawing(name: string): Promise<DrawingBody>;
  saveDrawing(body: DrawingBody): Promise<unknown>;
  deleteDrawing(name: string): Promise<unknown>;
}

/** The drawings kept by the server. */
export class SavedDrawings {
  readonly store = new Store<{ readonly list: readonly DrawingInfo[] }>({ list: [] });

  constructor(
    private readonly drawing: Drawing,
    private readonly keeper: DrawingKeeper,
    private readonly operations: Pick<Operations, "attempt">,
  ) {}

  async learn(): Promise<void> {
    await this.operations.attempt("Drawings not listed", async () => {
      this.store.patch({ list: await this.keeper.drawings() });
    });
  }

  /** Keep the drawing under its name; one of that name is replaced. */
  async save(): Promise<void> {
    const body = bodyOf(this.drawing.store.get());
    if (!body) return;
    await this.operations.attempt("Drawing not saved", () => this.keeper.saveDrawing(body));
    await this.learn();
  }

  async load(name: string): Promise<void> {
    await this.operations.attempt("Drawing not loaded", async () => {
      this.drawing.load(await this.keeper.drawing(name));
    });
  }

  async remove(name: string): Promise<void> {
    await this.operations.attempt("Drawing not deleted", () => this.keeper.deleteDrawing(name));
    await this.learn();
  }
}
