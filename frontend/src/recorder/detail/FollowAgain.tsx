import { Button, Menu } from "@mantine/core";
import { IconRoute } from "@tabler/icons-react";
import { useState } from "react";
import type { Recording } from "../../api/types";
import { Drawing } from "../../drawing/drawing";
import { PageStore } from "../../live/page";
import { Operations } from "../../operate/operations";
import { useService } from "../../ui/services";
import { recordings } from "../recordings";

const PATHS = [
  ["p_ref", "The reference", "What the tip was asked to do"],
  ["p_meas", "The measured tip", "What it did, with the camera's noise"],
] as const;
type What = (typeof PATHS)[number][0];
/** Takes the camera's noise out of a measured path [m]. */
const SMOOTHING = { p_ref: 0, p_meas: 0.001 };

/** Puts a recorded path into the Run tab as a drawing, with its own timing. */
export function FollowAgain({ recording }: { readonly recording: Recording }) {
  const drawing = useService(Drawing);
  const operations = useService(Operations);
  const page = useService(PageStore);
  const [busy, setBusy] = useState(false);
  const follow = async (what: What) => {
    setBusy(true);
    await operations.attempt("Path not taken", async () => {
      const { name, points, times } = await recordings.path(recording.id, what);
      drawing.load({
        name,
        points,
        times,
        pieces: null,
        closed: false,
        smoothing: SMOOTHING[what],
        timing: { kind: "given" },
        outside: "project",
      });
      drawing.chooseSource("drawing");
      page.patch({ view: "live" });
    });
    setBusy(false);
  };
  return (
    <Menu position="bottom-end" shadow="md">
      <Menu.Target>
        <Button
          size="compact-sm"
          variant="default"
          loading={busy}
          leftSection={<IconRoute size={14} />}
          title="Take a recorded path into the Run tab"
          data-testid="follow-again"
        >
          Follow again
        </Button>
      </Menu.Target>
      <Menu.Dropdown aria-label="Follow again">
        {PATHS.map(([what, label, meaning]) => (
          <Menu.Item
            key={what}
            disabled={recording.imported && what === "p_ref"}
            data-testid={`follow-${what}`}
            onClick={() => void follow(what)}
          >
            {label}
            <span className="note profile-meaning">{meaning}</span>
          </Menu.Item>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}
