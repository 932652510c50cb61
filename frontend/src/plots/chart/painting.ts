import type { Ring } from "../../live/ring";
import type { Painters } from "../../ui/painters";
import type { PlotMark } from "./marks";
import type { ChartPainter } from "./painter";
import { moved, scaled, visible, whole, zoomed, type Gesture, type Now, type View } from "./view";

/** Most charts that are painted in one frame while they follow the rig: no frame gets long, however many they are. */
const TOGETHER = 4;

/**
 * Keeps all charts up to date. While they follow the rig they take turns, on average one in a frame, but several of them
 * in the same frame: the browser lays the whole page together again in every frame in which anything was painted.
 */
export class Painting {
  private readonly charts: ChartPainter[] = [];
  private next = 0;
  /** Frames since charts that follow were painted. */
  private waited = 0;
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

  /** Once a frame; `marks` on the rig's clock [s] are the same object while they are the same. */
  step(view: View, seconds: number, marks: readonly PlotMark[]): void {
    const now = this.now(seconds);
    const range = visible(view, now);
    if (!Number.isFinite(range.to)) return;
    const origin = view.stoppedAt ?? now.newest;
    const seen = this.charts.filter((chart) => chart.seen);
    const most = view.stoppedAt === null ? Math.min(TOGETHER, seen.length) : seen.length;
    this.waited += 1;
    if (view.stoppedAt === null && this.waited < most) return;
    for (let tried = 0, painted = 0; tried < seen.length && painted < most; tried++) {
      this.next = (this.next + 1) % seen.length;
      const chart = seen[this.next];
      this.painters.run(chart, performance.now(), () => {
        if (!chart.follow(this.ring, range, origin, marks)) return;
        painted += 1;
        this.waited = 0;
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
