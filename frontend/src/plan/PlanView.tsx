import { Button, useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef } from "react";
import { useDashboard, usePage } from "../panels/context";
import { publishProbe } from "../testing";
import { RESIDUAL_GAIN } from "./figure";
import { Plan } from "./plan";

/** The plan view: two canvases that follow the stream by themselves, and the words around them. */
export function PlanView() {
  const dashboard = useDashboard();
  const scheme = useComputedColorScheme("dark");
  const paper = useRef<HTMLCanvasElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const cursor = useRef<HTMLSpanElement>(null);
  const plan = useRef<Plan>(null);
  useEffect(() => {
    if (!paper.current || !canvas.current) return;
    const made = new Plan(dashboard, paper.current, canvas.current);
    made.onHover = (point) => {
      const text = point ? point.map((v) => (v * 1e3).toFixed(1)).join(", ") + " mm" : "";
      if (cursor.current) cursor.current.textContent = text;
    };
    plan.current = made;
    publishProbe(dashboard, made);
    return made.start();
  }, [dashboard]);
  useEffect(() => {
    plan.current?.useScheme(scheme);
  }, [scheme]);
  const twin = usePage((page) => page.rig?.twin ?? false);
  const planned = usePage((page) => page.reference !== null);
  return (
    <section className="plan" aria-label="Plan view">
      <canvas ref={paper} className="plan-canvas" aria-hidden />
      <canvas
        ref={canvas}
        className="plan-canvas plan-figure"
        data-plan
        data-testid="plan"
        tabIndex={0}
        role="application"
        aria-label="Plan of the actuator. Arrow keys move the target by 1 mm, with Shift 10 mm, with Control 0.1 mm."
      />
      <Legend twin={twin} planned={planned} />
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

function Legend({ twin, planned }: { readonly twin: boolean; readonly planned: boolean }) {
  return (
    <ul className="legend" aria-label="Legend">
      <li>
        <i className="key key-target" /> target
      </li>
      <li>
        <i className="key key-reference">+</i> reference
      </li>
      {planned ? (
        <li>
          <i className="key key-planned" /> path
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
