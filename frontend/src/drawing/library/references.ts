import { api, named, dataOf } from "../../api/rest";
import type { ReferenceInfo } from "../../api/types";
import { keep, type Page } from "../../live/page";
import type { Operations } from "../../operate/operations";
import type { Store } from "../../ui/store";

/** Where references come from: the server, or a test. */
export const library = {
  references: () => dataOf(api.GET("/api/references")),
  reference: (name: string) => dataOf(api.GET("/api/references/{name}", named(name))),
};

/** The reference menu, and the one reference that is drawn on the plan. */
export class References {
  constructor(
    private readonly page: Store<Page>,
    private readonly operations: Pick<Operations, "report">,
    private readonly source = library,
  ) {}

  /** Learn the menu of the rig that was met; a chosen reference is drawn again, as this rig's actuator has it. */
  async learn(): Promise<void> {
    try {
      const references = await this.source.references();
      this.page.patch({ references: keep(this.page.get().references, references) });
      await this.choose(this.page.get().chosen);
    } catch (error) {
      this.operations.report("References not known", error);
    }
  }

  /** Draw the reference of this name, none for null. An answer to an older choice is dropped. */
  async choose(name: string | null): Promise<void> {
    const shown = this.page.get().reference;
    this.page.patch({ chosen: name, reference: shown?.name === name ? shown : null });
    if (name === null) return;
    try {
      const reference = await this.source.reference(name);
      if (this.page.get().chosen === name) this.page.patch({ reference: keep(shown, reference) });
    } catch (error) {
      if (this.page.get().chosen === name) this.page.patch({ chosen: null, reference: null });
      this.operations.report("Reference not shown", error);
    }
  }
}

/** The menu's entry of the chosen reference. */
export function chosenInfo({ references, chosen }: Page): ReferenceInfo | null {
  return references.find(({ name }) => name === chosen) ?? null;
}
