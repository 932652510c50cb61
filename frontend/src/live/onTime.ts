/** Share of time slots in which the loop ticked, over the last minute. */
const WINDOW_S = 60;
const EVERY_S = 1;

interface Mark {
  readonly slot: number;
  readonly lost: number;
  readonly at: number;
}

export class OnTime {
  private marks: Mark[] = [];
  private latest: Mark | null = null;

  clear(): void {
    this.marks = [];
    this.latest = null;
  }

  /** The loop was at `slot`, having lost `lost` slots since its start, at page time `at` [s]. */
  add(slot: number, lost: number, at: number): void {
    if (this.latest && slot < this.latest.slot) this.clear();
    this.latest = { slot, lost, at };
    const last = this.marks.at(-1);
    if (!last || at - last.at >= EVERY_S) this.marks.push(this.latest);
    while (this.marks.length > 1 && at - this.marks[0].at > WINDOW_S) this.marks.shift();
  }

  /** Slots lost in the same time, nan before the first mark. */
  lost(): number {
    const first = this.marks.at(0);
    return first && this.latest ? this.latest.lost - first.lost : NaN;
  }

  /** On-time share in 0..1, nan before two marks. */
  share(): number {
    const first = this.marks.at(0);
    if (!first || !this.latest || this.latest.slot <= first.slot) return NaN;
    return 1 - (this.latest.lost - first.lost) / (this.latest.slot - first.slot);
  }
}
