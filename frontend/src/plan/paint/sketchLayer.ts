import type { Point, ReferencePath } from "../../api/types";
import type { Dashboard } from "../../app/dashboard";
import { isSame } from "../../drawing/planner";
import { chosenInfo } from "../../drawing/library/references";
import type { Sheet } from "./canvas";
import { paintPlanned, plannedLines, type PlannedLines } from "./planned";
import { paintDrawing, paintGhost } from "./sketch";

/** What is wanted and predicted, between paper and figure: painted when it or the view changes. */
export class SketchLayer {
  /** Where the pointer is [m]. */
  cursor: Point | null = null;
  private painted: readonly unknown[] = [];
  private reference: ReferencePath | null = null;
  private planned: PlannedLines | null = null;

  constructor(private readonly dashboard: Dashboard) {}

  /** Paint on the sheet that `open` gives, if there is something new; `look` says how it is looked at. */
  paint(look: readonly unknown[], open: () => Sheet | null): void {
    const { drawing, runs, page } = this.dashboard;
    const { source, preview } = runs.store.get();
    const state = drawing.store.get();
    const cursor = state.stroke.length > 0 ? this.cursor : null;
    const shown = [...look, source, preview, state, page.get().reference, cursor];
    if (isSame(shown, this.painted)) return;
    const sheet = open();
    if (!sheet) return;
    sheet.g.clearRect(0, 0, sheet.size.width, sheet.size.height);
    if (source === "library") this.paintReference(sheet);
    else paintDrawing(sheet, state, cursor);
    if (preview) paintGhost(sheet, preview);
    this.painted = shown;
  }

  private paintReference(sheet: Sheet): void {
    const { reference } = this.dashboard.page.get();
    if (reference !== this.reference) {
      const frequency = chosenInfo(this.dashboard.page.get())?.frequency ?? null;
      this.reference = reference;
      this.planned = reference && plannedLines(reference, frequency);
    }
    if (this.planned) paintPlanned(sheet, this.planned);
  }
}
