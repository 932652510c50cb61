import { Button, Tooltip } from "@mantine/core";
import { recordings } from "../api/recordings";
import type { Recording } from "../api/types";
import { useDashboard } from "../panels/context";

/** Puts the recorded path into the Run tab as a drawing, with its own timing. */
export function FollowAgain({ recording }: { readonly recording: Recording }) {
  const { drawing, operations, page, runs } = useDashboard();
  const follow = () =>
    operations.attempt("Path not taken", async () => {
      const { points, times } = await recordings.path(recording.id);
      drawing.load({
        name: recording.name,
        points: points.map(([x, y]) => [x, y]),
        times,
        closed: false,
        smoothing: 0,
        timing: { kind: "given" },
        outside: "project",
      });
      runs.choose("drawing");
      page.patch({ view: "live" });
    });
  return (
    <Tooltip label="Take the recorded path into the Run tab">
      <Button size="compact-sm" variant="default" data-testid="follow-again" onClick={() => void follow()}>
        Follow again
      </Button>
    </Tooltip>
  );
}
