import { ActionIcon, Button, Tooltip, useComputedColorScheme } from "@mantine/core";
import { IconChevronDown, IconChevronRight } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import { Drawing } from "../drawing/drawing";
import { PageStore, usePage } from "../live/page";
import { Runs } from "../runs/runs";
import { useService } from "../ui/services";
import type { SceneView } from "./scene";
import { SceneFrame } from "./SceneFrame";
import { sceneLines, ViewSession } from "./viewSession";

const SHOWN = "tendril-3d";
const VIEWS: readonly (readonly [SceneView, string, string])[] = [
  ["top", "Top", "Look from above, as the plan does"],
  ["oblique", "Oblique", "Look from the side"],
];

/** viser's 3D view: loaded when first opened, collapsible, and remembered. */
export function Scene3D() {
  const [open, setOpen] = useState(() => localStorage.getItem(SHOWN) !== "closed");
  const toggle = () => {
    localStorage.setItem(SHOWN, open ? "closed" : "open");
    setOpen(!open);
  };
  return (
    <section className={open ? "scene" : "scene scene-closed"} aria-label="3D view">
      {open ? <OpenScene onClose={toggle} /> : <Bar open={false} onToggle={toggle} />}
    </section>
  );
}

function OpenScene({ onClose }: { readonly onClose: () => void }) {
  const drawing = useService(Drawing);
  const page = useService(PageStore);
  const runs = useService(Runs);
  const [viewSession] = useState(() => new ViewSession());
  useEffect(() => {
    // The stores live outside React: each change of what the plan shows goes to the viewSession.
    const show = () => viewSession.show(sceneLines(page.get(), drawing.store.get(), runs.store.get()));
    show();
    const stops = [page, drawing.store, runs.store].map((store) => store.subscribe(show));
    return () => {
      for (const stop of stops) stop();
    };
  }, [drawing, page, runs, viewSession]);
  return (
    <>
      <Bar open onToggle={onClose} viewSession={viewSession} />
      <SceneFrame viewSession={viewSession} title="3D view of the actuator" />
      <Why />
    </>
  );
}

/** Why the last touch of the gizmo did nothing; screen readers hear it from the plan. */
function Why() {
  const hint = usePage((page) => page.hint);
  return hint === "" ? null : (
    <div className="hint hint-on scene-hint" aria-hidden="true" data-testid="scene-hint">
      {hint}
    </div>
  );
}

interface BarProps {
  readonly open: boolean;
  readonly onToggle: () => void;
  readonly viewSession?: ViewSession;
}

function Bar({ open, onToggle, viewSession }: BarProps) {
  return (
    <div className="bar">
      <ActionIcon
        variant="subtle"
        color="gray"
        size="sm"
        aria-expanded={open}
        aria-label="3D view"
        data-testid="toggle-3d"
        onClick={onToggle}
      >
        {open ? <IconChevronDown size={16} /> : <IconChevronRight size={16} />}
      </ActionIcon>
      <span className="bar-title">3D</span>
      <span className="spacer" />
      {viewSession ? <Cameras viewSession={viewSession} /> : null}
    </div>
  );
}

/** Buttons that put the camera back to where a view is taken from; for this page alone. */
export function Cameras({ viewSession }: { readonly viewSession: ViewSession }) {
  const scheme = useComputedColorScheme("dark");
  return (
    <Button.Group aria-label="Camera">
      {VIEWS.map(([view, label, meaning]) => (
        <Tooltip key={view} label={meaning} openDelay={500}>
          <Button
            size="compact-xs"
            variant="default"
            data-testid={`camera-${view}`}
            onClick={() => viewSession.look(scheme, view)}
          >
            {label}
          </Button>
        </Tooltip>
      ))}
    </Button.Group>
  );
}
