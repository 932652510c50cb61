import { Live } from "../live/live";
import { TargetControl } from "../operate/target/targetControl";
import type { Services } from "../ui/services";
import type { Plan } from "./plan";

/** What browser tests may read of the running page, as `window.__tendril`; millimetres and window pixels. */
export interface Probe {
  /** Every field of the newest telemetry record by name, null before the first. */
  readonly frame: Record<string, number | number[]> | null;
  /** Telemetry frames received so far. */
  readonly frames: number;
  /** Handler-to-reply times of moved targets [ms]. */
  readonly roundTrips: readonly number[];
  toPixel(xMm: number, yMm: number): readonly [number, number];
  toPlane(px: number, py: number): readonly [number, number];
  /** Where the target handle is drawn [window pixels]. */
  handle(): readonly [number, number] | null;
}

declare global {
  interface Window {
    __tendril?: Probe;
  }
}

export function publishProbe(services: Services, plan: Plan): void {
  const [targetControl, live] = [services.get(TargetControl), services.get(Live)];
  window.__tendril = {
    get frame() {
      return live.frames === 0 || !live.telemetry ? null : live.telemetry.snapshot();
    },
    get frames() {
      return live.frames;
    },
    roundTrips: targetControl.targets.roundTrips,
    toPixel: (xMm, yMm) => plan.clientOf([xMm / 1e3, yMm / 1e3]),
    toPlane: (px, py) => {
      const [x, y] = plan.planeOf([px, py]);
      return [x * 1e3, y * 1e3];
    },
    handle: () => {
      const handle = targetControl.handle(performance.now());
      return handle && plan.clientOf(handle.point);
    },
  };
}
