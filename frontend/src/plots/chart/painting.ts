import type { Ring } from "../../live/ring";
import type { Painters } from "../../ui/painters";
import type { ChartPainter } from "./painter";
import { moved, scaled, visible, whole, zoomed, type Gesture, type Now, type View } from "./view";

/** Keeps all charts up to date, one in a frame while they follow the rig: no frame gets long, however many they are. */
export class Painting {
  private readonly charts: ChartPainter[] = [];
  private next = 0;
  private heldAt: number | null = null;

  constructor(
    private readonly ring: Ring,
    private readonly painters: Painters,
  ) {}

  /** Keep a chart up to date; returns how to stop it. */
  add(painter: ChartPainter): () => void {
    this.charts.push(painter);
    return () => {
      this.charts.splice(this.charts.indexOf(painter), 1);
      this.painters.recovered(painter);
    };
  }

  now(seconds: number): Now {
    return { newest: this.heldAt ?? this.ring.newest, seconds };
  }

  /** Once a frame. */
  step(view: View, seconds: number): void {
    const now = this.now(seconds);
    const range = visible(view, now);
    if (!Number.isFinite(range.to)) return;
    const origin = view.stoppedAt ?? now.newest;
    const most = view.stoppedAt === null ? 1 : this.charts.length;
    for (let tried = 0, painted = 0; tried < this.charts.length && painted < most; tried++) {
      this.next = (this.next + 1) % this.charts.length;
      const chart = this.charts[this.next];
      this.painters.run(chart, performance.now(), () => {
        if (chart.follow(this.ring, range, origin)) painted += 1;
      });
    }
  }

  /** Write every chart's newest values: all at once, since any text that changes makes the browser lay out the page. */
  writeValues(): void {
    for (const chart of this.charts)
      this.painters.run(chart, performance.now(), () => {
        chart.writeValues();
      });
  }

  /** The view after a gesture. */
  after(gesture: Gesture, view: View, seconds: number): View {
    const now = this.now(seconds);
    switch (gesture.kind) {
      case "zoom":
        return zoomed(view, gesture, now);
      case "scale":
        return scaled(view, gesture.factor, gesture.about, now);
      case "move":
        return moved(view, gesture.seconds, now);
      case "whole":
        return whole(view);
      case "hold":
        this.heldAt = gesture.held ? (this.heldAt ?? this.ring.newest) : null;
        return view;
    }
  }
}
