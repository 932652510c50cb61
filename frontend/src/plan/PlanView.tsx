import { Button, useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef } from "react";
import { useDrawing } from "../drawing/drawing";
import { DrawHint } from "../drawing/tools/DrawHint";
import { DrawToolbar } from "../drawing/tools/DrawToolbar";
import { useDrawKeys } from "../drawing/tools/useDrawKeys";
import { usePage } from "../live/page";
import { useRuns } from "../runs/runs";
import { useServices } from "../ui/services";
import { RESIDUAL_GAIN } from "./paint/figure";
import { Plan } from "./plan";
import { publishProbe } from "./probe";

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
  const twin = usePage((page) => page.rig?.twin ?? false);
  useDrawKeys();
  return (
    <section className="plan" aria-label="Plan view">
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
      <DrawToolbar />
      <Legend twin={twin} />
      <DrawHint />
      <Hint />
      <span ref={cursor} className="plan-cursor number" data-testid="cursor" />
      <Button
        className="plan-fit"
        size="compact-xs"
        variant="default"
        onClick={() => {
          plan.current?.fit();
        }}
      >
        Fit
      </Button>
    </section>
  );
}

function Legend({ twin }: { readonly twin: boolean }) {
  const chosen = usePage((page) => page.reference !== null);
  const drawing = useDrawing((state) => state.source === "drawing");
  const ghost = useRuns((choice) => choice.ghost !== null);
  const saturated = useRuns((choice) => (choice.preview?.saturated_share ?? 0) > 0);
  return (
    <ul className="legend" aria-label="Legend">
      <li>
        <i className="key key-target" /> target
      </li>
      <li>
        <i className="key key-reference">+</i> reference
      </li>
      {chosen || drawing ? (
        <li>
          <i className="key key-planned" /> path
        </li>
      ) : null}
      {drawing ? (
        <li>
          <i className="key key-outside" /> out of reach
        </li>
      ) : null}
      {ghost ? (
        <li>
          <i className="key key-ghost" /> predicted
        </li>
      ) : null}
      {saturated ? (
        <li>
          <i className="key key-saturated" /> saturated
        </li>
      ) : null}
      <li>
        <i className="key key-measured" /> measured (arrows: residual × {RESIDUAL_GAIN})
      </li>
      <li>
        <i className="key key-observer" /> observer
      </li>
      <li>
        <i className="key key-reach" /> reach
      </li>
      {twin ? (
        <li>
          <i className="key key-twin" /> twin
        </li>
      ) : null}
    </ul>
  );
}

/** Why the last touch of the target did nothing. */
function Hint() {
  const hint = usePage((page) => page.hint);
  return (
    <div className={hint ? "hint hint-on" : "hint"} role="status" data-testid="hint">
      {hint}
    </div>
  );
}
