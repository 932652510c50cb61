import { Button, useComputedColorScheme } from "@mantine/core";
import { useEffect, useLayoutEffect, useRef } from "react";
import type { Point } from "../api/types";
import { DrawHint } from "../drawing/tools/DrawHint";
import { DrawToolbar } from "../drawing/tools/DrawToolbar";
import { useDrawKeys } from "../drawing/tools/useDrawKeys";
import { usePage } from "../live/page";
import { RunTrace } from "../runs/trace";
import { useService, useServices, type Services } from "../ui/services";
import { useStore } from "../ui/store";
import { Legend } from "./Legend";
import { Plan } from "./plan";
import { Live } from "../live/live";
import { TargetControl } from "../operate/target/targetControl";

/** The plan view: canvases that follow the stream by themselves, and the tools and words around them. */
export function PlanView() {
  const services = useServices();
  const scheme = useComputedColorScheme("dark");
  const paper = useRef<HTMLCanvasElement>(null);
  const sketch = useRef<HTMLCanvasElement>(null);
  const figure = useRef<HTMLCanvasElement>(null);
  const cursor = useRef<HTMLSpanElement>(null);
  const plan = useRef<Plan>(null);
  useEffect(() => {
    if (!paper.current || !sketch.current || !figure.current) return;
    const made = new Plan(services, {
      paper: paper.current,
      sketch: sketch.current,
      figure: figure.current,
    });
    made.onHover = (point) => {
      const text = point ? point.map((v) => (v * 1e3).toFixed(1)).join(", ") + " mm" : "";
      if (cursor.current) cursor.current.textContent = text;
    };
    plan.current = made;
    publishProbe(services, made);
    return made.start();
  }, [services]);
  useEffect(() => {
    plan.current?.useScheme(scheme);
  }, [scheme]);
  useDrawKeys();
  return (
    <section className="plan" aria-label="Plan view">
      <div className="plan-bar">
        <DrawToolbar />
        <Legend />
        <Button
          className="plan-fit"
          size="compact-xs"
          variant="subtle"
          color="gray"
          onClick={() => plan.current?.fit()}
        >
          Fit
        </Button>
      </div>
      <div className="plan-field">
        <canvas ref={paper} className="plan-canvas" aria-hidden />
        <canvas ref={sketch} className="plan-canvas" aria-hidden />
        <canvas
          ref={figure}
          className="plan-canvas plan-figure"
          data-plan
          data-testid="plan"
          tabIndex={0}
          role="application"
          aria-label="Plan of the actuator. Arrow keys move the target by 1 mm, with Shift 10 mm, with Control 0.1 mm."
        />
        <DrawHint />
        <Hint at={() => plan.current?.handleAt() ?? null} />
        <span ref={cursor} className="plan-cursor number" data-testid="cursor" />
        <ClearTrace />
      </div>
    </section>
  );
}

/** From the target's middle to what is said above it [px]: a finger covers less. */
const OVER_TARGET_PX = 34;

/** The measured path of the last run stays until it is cleared. */
function ClearTrace() {
  const trace = useService(RunTrace);
  const any = useStore(trace.store, ({ legs }) => legs.length > 0);
  if (!any) return null;
  return (
    <Button
      className="plan-clear-trace"
      size="compact-xs"
      variant="default"
      data-testid="clear-trace"
      title="Remove the measured path of the last run from the plan"
      onClick={() => trace.clear()}
    >
      Clear trace
    </Button>
  );
}

/** Why the last touch of the target did nothing, above the target, which is `at` this place of the field [px]; in the lower middle without. */
function Hint({ at }: { readonly at: () => Point | null }) {
  const hint = usePage((page) => page.hint);
  const box = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const [element, field] = [box.current, box.current?.parentElement];
    if (!element || !field || hint === "") return;
    const target = at() ?? [field.clientWidth / 2, field.clientHeight];
    const half = element.offsetWidth / 2;
    const x = Math.max(half, Math.min(target[0], field.clientWidth - half));
    const y = Math.max(0, Math.min(target[1] - OVER_TARGET_PX, field.clientHeight) - element.offsetHeight);
    element.style.transform = `translate(${Math.round(x - half)}px, ${Math.round(y)}px)`;
  });
  return (
    <div ref={box} className={hint ? "hint hint-on" : "hint"} role="status" data-testid="hint">
      {hint}
    </div>
  );
}

/** What browser tests may read of the running page, as `window.__tendril`; millimetres and window pixels. */
interface Probe {
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

function publishProbe(services: Services, plan: Plan): void {
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
