import { api, named, dataOf } from "../../api/rest";
import type { Macro, MacroState, MacroStep } from "../../api/types";
import type { Page } from "../../live/page";
import type { Operations } from "../../operate/operations";
import { Store } from "../../ui/store";

type Kind = MacroStep["do"];

/** What each kind of step is called, and how a new one begins; in the order of the menu. */
export const KINDS: { readonly [K in Kind]: readonly [string, Extract<MacroStep, { do: K }>] } = {
  arm: ["Arm", { do: "arm" }],
  hold: ["Hold", { do: "hold" }],
  clear: ["Clear", { do: "clear" }],
  reference: ["Follow a reference", { do: "reference", name: "", laps: 1 }],
  drawing: ["Follow a drawing", { do: "drawing", name: "", laps: 1 }],
  target: ["Move the target", { do: "target", x: 0.1, y: 0.1 }],
  wait: ["Wait", { do: "wait", seconds: 3 }],
  run_end: ["Wait for the run's end", { do: "run_end" }],
  preset: ["Load gains", { do: "preset", name: "" }],
  record: ["Record", { do: "record", name: "", profile: "standard" }],
  record_end: ["End the recording", { do: "record_end" }],
  mark: ["Bookmark", { do: "mark", label: "" }],
};

/** A macro that is being written; `was` is its name on the server, null for a new one. */
export interface Draft {
  readonly was: string | null;
  readonly name: string;
  readonly steps: readonly MacroStep[];
}

export interface MacrosState {
  /** Mine, by name. */
  readonly list: readonly Macro[];
  readonly draft: Draft | null;
}

const server = {
  list: () => dataOf(api.GET("/api/macros")),
  keep: (name: string, steps: readonly MacroStep[]) =>
    dataOf(api.PUT("/api/macros/{name}", { ...named(name), body: { steps: [...steps] } })),
  remove: (name: string) => dataOf(api.DELETE("/api/macros/{name}", named(name))),
  run: (name: string) => dataOf(api.POST("/api/macros/{name}/run", named(name))),
  stop: () => dataOf(api.POST("/api/macros/stop")),
};

/** The macros that the server keeps for this browser: written, run and stopped; who looks is told how one ended. */
export class Macros {
  readonly store = new Store<MacrosState>({ list: [], draft: null });
  private running = "";

  constructor(
    page: Store<Page>,
    private readonly operations: Pick<Operations, "attempt" | "notify">,
    private readonly port = server,
  ) {
    page.subscribe(() => {
      this.look(page.get().macro);
    });
  }

  async learn(): Promise<void> {
    await this.operations.attempt("Macros not known", async () => {
      this.store.patch({ list: await this.port.list() });
    });
  }

  async run(name: string): Promise<void> {
    await this.operations.attempt("Macro not run", () => this.port.run(name));
  }

  async stop(): Promise<void> {
    await this.operations.attempt("Macro not stopped", () => this.port.stop());
  }

  async remove(name: string): Promise<void> {
    await this.operations.attempt("Macro not deleted", async () => {
      this.store.patch({ list: await this.port.remove(name) });
    });
  }

  /** Write at a kept macro, or at a new one. */
  edit(macro: Macro | null): void {
    const { name = "", steps = [KINDS.arm[1]] } = macro ?? {};
    this.store.patch({ draft: { was: macro?.name ?? null, name, steps } });
  }

  change(change: Partial<Draft>): void {
    const { draft } = this.store.get();
    if (draft) this.store.patch({ draft: { ...draft, ...change } });
  }

  drop(): void {
    this.store.patch({ draft: null });
  }

  /** Keep what was written; under another name it is kept first, and then forgotten under the one before. */
  async save(): Promise<void> {
    const { draft } = this.store.get();
    if (!draft) return;
    const name = draft.name.trim();
    await this.operations.attempt("Macro not saved", async () => {
      let list = await this.port.keep(name, draft.steps);
      if (draft.was !== null && draft.was !== name) list = await this.port.remove(draft.was);
      this.store.patch({ list, draft: null });
    });
  }

  private look(macro: MacroState | null): void {
    const before = this.running;
    this.running = macro?.state === "running" ? macro.name : "";
    if (macro && before === macro.name && macro.state === "ended")
      this.operations.notify("warning", `${titleOf(macro)} ended`, endText(macro));
  }
}

const NAME = /^[\p{L}\p{N}_ .+()-]{1,40}$/u;

/** Why it cannot be saved, as one sentence; null when it can. */
export function whyNotSaved({ was, name, steps }: Draft, list: readonly Macro[]): string | null {
  if (!NAME.test(name.trim())) return "Give it a name of letters, digits and . + - _ ( )";
  if (name.trim() !== was && list.some((macro) => macro.name === name.trim()))
    return "There is a macro of this name already";
  if (steps.length === 0) return "It has no step yet";
  const nameless = steps.findIndex(
    (step) => (step.do === "reference" || step.do === "drawing" || step.do === "preset") && step.name === "",
  );
  return nameless < 0 ? null : `Choose what step ${nameless + 1} takes`;
}

/** The steps with number `from` one place up or down. */
export function moved(steps: readonly MacroStep[], from: number, by: -1 | 1): readonly MacroStep[] {
  const to = from + by;
  if (to < 0 || to >= steps.length) return steps;
  return steps.with(from, steps[to]).with(to, steps[from]);
}

/** Where it is: "step 2 of 5, wait 3 s", or "repeat 2 of 8". */
export function stepText({ step, steps, doing, learning }: MacroState): string {
  return learning ? `repeat ${step} of ${steps}` : `step ${step} of ${steps}, ${doing}`;
}

/** What runs: "Macro warm up", or "Learning vu". */
export function titleOf({ name, learning }: MacroState): string {
  return `${learning ? "Learning" : "Macro"} ${name}`;
}

/** How it ended. */
export function endText(macro: MacroState): string {
  return macro.state === "done" ? "done" : `ended at ${stepText(macro)}: ${macro.reason}`;
}
