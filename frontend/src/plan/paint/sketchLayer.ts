import type { Point, ReferencePath } from "../../api/types";
import type { Drawing } from "../../drawing/drawing";
import { chosenInfo } from "../../drawing/library/references";
import { plannedLines, type PlannedLines } from "../../drawing/library/shown";
import { isSame } from "../../drawing/planner";
import type { Page } from "../../live/page";
import type { Runs } from "../../runs/runs";
import type { RunTrace } from "../../runs/trace";
import type { Store } from "../../ui/store";
import type { Look, Sheet } from "./canvas";
import { paintPlanned } from "./planned";
import { paintDrawing, paintGhost, paintTrace } from "./sketch";

/** What is wanted and predicted, between paper and figure: painted when it or the view changes. */
export class SketchLayer {
  /** Where the pointer is [m]. */
  cursor: Point | null = null;
  private painted: readonly unknown[] = [];
  private reference: ReferencePath | null = null;
  private planned: PlannedLines | null = null;

  constructor(
    private readonly drawing: Drawing,
    private readonly runs: Runs,
    private readonly trace: RunTrace,
    private readonly page: Store<Page>,
  ) {}

  /** Paint on the sheet that `open` gives, if there is something new. */
  paint(look: Look, open: () => Sheet | null): void {
    const { ghost } = this.runs.store.get();
    const state = this.drawing.store.get();
    const cursor = state.stroke.length > 0 ? this.cursor : null;
    const { legs } = this.trace.store.get();
    const shown = [look, ghost, state, this.page.get().reference, cursor, legs];
    if (isSame(shown, this.painted)) return;
    const sheet = open();
    if (!sheet) return;
    sheet.g.clearRect(0, 0, sheet.size.width, sheet.size.height);
    if (state.source === "drawing" && (!look.hidden.has("path") || state.tool !== "drag"))
      paintDrawing(sheet, state, cursor);
    if (state.source === "library" && !look.hidden.has("path")) this.paintReference(sheet);
    if (ghost && !look.hidden.has("predicted")) paintGhost(sheet, ghost);
    if (!look.hidden.has("measured")) paintTrace(sheet, legs);
    this.painted = shown;
  }

  private paintReference(sheet: Sheet): void {
    const page = this.page.get();
    const { reference } = page;
    if (reference !== this.reference) {
      const frequency = chosenInfo(page)?.frequency ?? null;
      this.reference = reference;
      this.planned = reference && plannedLines(reference, frequency);
    }
    if (this.planned) paintPlanned(sheet, this.planned);
  }
}
