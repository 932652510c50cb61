import { ActionIcon, SegmentedControl, Tooltip } from "@mantine/core";
import { IconChevronDown, IconChevronRight } from "@tabler/icons-react";
import { useState } from "react";

const SHOWN = "tendril-3d";

/** viser's 3D view: loaded when first opened, collapsible, and remembered. */
export function Scene3D() {
  const [open, setOpen] = useState(() => localStorage.getItem(SHOWN) !== "closed");
  const [camera, setCamera] = useState("top");
  const toggle = () => {
    localStorage.setItem(SHOWN, open ? "closed" : "open");
    setOpen(!open);
  };
  return (
    <section className={open ? "scene" : "scene scene-closed"} aria-label="3D view">
      <div className="bar">
        <ActionIcon
          variant="subtle"
          color="gray"
          size="sm"
          aria-expanded={open}
          aria-label="3D view"
          data-testid="toggle-3d"
          onClick={toggle}
        >
          {open ? <IconChevronDown size={16} /> : <IconChevronRight size={16} />}
        </ActionIcon>
        <span className="bar-title">3D</span>
        <span className="spacer" />
        {open ? (
          <Tooltip label="Start the camera here again">
            <SegmentedControl
              size="xs"
              aria-label="Camera"
              value={camera}
              onChange={setCamera}
              data={[
                { value: "top", label: "Top" },
                { value: "oblique", label: "Oblique" },
              ]}
            />
          </Tooltip>
        ) : null}
      </div>
      {open ? (
        <iframe
          key={camera}
          className="scene-frame"
          title="3D view of the actuator"
          src={`/viser/?view=${camera}`}
        />
      ) : null}
    </section>
  );
}
