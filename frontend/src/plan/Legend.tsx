import { Tooltip } from "@mantine/core";
import type { ReactNode } from "react";
import { useDrawing } from "../drawing/drawing";
import { usePage } from "../live/page";
import { useRuns } from "../runs/runs";
import { useService } from "../ui/services";
import { Layers, useHidden, type Layer } from "./layers";
import { RESIDUAL_GAIN } from "./paint/figure";

/** What the colours of the plan mean; a press on one switches what it names. */
export function Legend() {
  const twin = usePage((page) => page.rig?.twin ?? false);
  const chosen = usePage((page) => page.reference !== null);
  const drawing = useDrawing((state) => state.source === "drawing");
  const travel = useDrawing((state) => (state.plan?.travel_duration ?? 0) > 0);
  const ghost = useRuns((choice) => choice.ghost !== null);
  const saturated = useRuns((choice) => (choice.preview?.saturated_share ?? 0) > 0);
  return (
    <ul className="legend" aria-label="Legend">
      <li className="layer">
        <i className="key key-target" /> target
      </li>
      <li className="layer">
        <i className="key key-reference">+</i> reference
      </li>
      {chosen || drawing ? (
        <Chip
          layer="path"
          meaning={
            drawing
              ? `The drawing; dotted red where it is out of reach${travel ? ", thin where the tip travels, which counts in no figure" : ""}`
              : "The path that a run follows"
          }
        >
          <i className="key key-planned" /> path
          {drawing && travel ? <i className="key key-travel" /> : null}
          {drawing ? <i className="key key-outside" /> : null}
        </Chip>
      ) : null}
      {ghost ? (
        <Chip
          layer="predicted"
          meaning={`What the twin foresees${saturated ? "; red where the command saturates" : ""}`}
        >
          <i className="key key-ghost" /> predicted
          {saturated ? <i className="key key-saturated" /> : null}
        </Chip>
      ) : null}
      <Chip layer="measured" meaning={`Markers and their trail; arrows: residual × ${RESIDUAL_GAIN}`}>
        <i className="key key-measured" /> measured
      </Chip>
      <Chip layer="observer" meaning="The backbone that the observer reconstructs">
        <i className="key key-observer" /> observer
      </Chip>
      <Chip layer="reach" meaning="Where the tip can rest">
        <i className="key key-reach" /> reach
      </Chip>
      {twin ? (
        <Chip layer="twin" meaning="The simulated actuator itself">
          <i className="key key-twin" /> twin
        </Chip>
      ) : null}
    </ul>
  );
}

interface ChipProps {
  readonly layer: Layer;
  readonly meaning: string;
  readonly children: ReactNode;
}

function Chip({ layer, meaning, children }: ChipProps) {
  const layers = useService(Layers);
  const shown = !useHidden().has(layer);
  return (
    <li>
      <Tooltip
        label={`${meaning}. Press to ${shown ? "hide" : "show"} it`}
        openDelay={400}
        multiline
        maw={280}
      >
        <button
          type="button"
          className="layer"
          aria-pressed={shown}
          data-testid={`layer-${layer}`}
          onClick={() => layers.toggle(layer)}
        >
          {children}
        </button>
      </Tooltip>
    </li>
  );
}
