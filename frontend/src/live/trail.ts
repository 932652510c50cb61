/** The last two seconds of the tip, in arrays made once. */
const KEPT_S = 2;
const CAPACITY = 256;

export class Trail {
  private readonly x = new Float64Array(CAPACITY);
  private readonly y = new Float64Array(CAPACITY);
  private readonly at = new Float64Array(CAPACITY);
  private end = 0;
  private count = 0;

  clear(): void {
    this.count = 0;
  }

  /** Add the point [m] seen at `now` [s]. */
  push(x: number, y: number, now: number): void {
    this.x[this.end] = x;
    this.y[this.end] = y;
    this.at[this.end] = now;
    this.end = (this.end + 1) % CAPACITY;
    this.count = Math.min(this.count + 1, CAPACITY);
  }

  /** Visit the points younger than two seconds, oldest first, with their freshness in 0..1. */
  visit(now: number, each: (x: number, y: number, freshness: number) => void): void {
    for (let back = this.count; back > 0; back--) {
      const slot = (this.end - back + CAPACITY) % CAPACITY;
      const freshness = 1 - (now - this.at[slot]) / KEPT_S;
      if (freshness > 0) each(this.x[slot], this.y[slot], freshness);
    }
  }
}
