import { Store } from "./store";

/** What draws, by the name that an operator knows. */
export interface Painter {
  readonly name: string;
}

/** A painter that threw is tried again after this time [ms]. */
export const RETRY_MS = 1000;

/** What draws side by side: one that throws is noted once, stops no other, and is tried again. */
export class Painters {
  /** Names of what is not drawn now, for the operator. */
  readonly failed = new Store<{ readonly names: readonly string[] }>({ names: [] });
  private readonly ill = new Map<Painter, number>();
  private readonly told = new Set<string>();

  /** `tell` is called once for each name and error. */
  constructor(private readonly tell: (name: string, error: unknown) => void) {}

  /** Paint at page time `now` [ms], unless `painter` threw less than a second ago. */
  run(painter: Painter, now: number, paint: () => void): void {
    const until = this.ill.get(painter);
    if (until !== undefined && now < until) return;
    try {
      paint();
      if (until !== undefined) this.recovered(painter);
    } catch (error) {
      this.threw(painter, now, error);
    }
  }

  /** `painter` threw `error` at page time `now` [ms]. */
  threw(painter: Painter, now: number, error: unknown): void {
    this.ill.set(painter, now + RETRY_MS);
    this.show();
    const text = `${painter.name}: ${String(error)}`;
    if (this.told.has(text)) return;
    this.told.add(text);
    this.tell(painter.name, error);
  }

  /** `painter` draws again, or is gone. */
  recovered(painter: Painter): void {
    if (this.ill.delete(painter)) this.show();
  }

  private show(): void {
    const names = [...new Set([...this.ill.keys()].map(({ name }) => name))];
    const before = this.failed.get().names;
    if (names.join() !== before.join()) this.failed.patch({ names });
  }
}
