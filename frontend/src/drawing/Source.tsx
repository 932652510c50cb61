import { SegmentedControl } from "@mantine/core";
import { useDashboard } from "../ui/context";
import { useRuns } from "./useDrawing";

/** What to follow: a reference of the library, or the drawing. */
export function RunSource() {
  const { runs } = useDashboard();
  const source = useRuns((choice) => choice.source);
  return (
    <SegmentedControl
      size="xs"
      aria-label="What to follow"
      value={source}
      onChange={(value) => {
        runs.choose(value === "drawing" ? "drawing" : "library");
      }}
      data={[
        { value: "library", label: "Library" },
        { value: "drawing", label: "Drawing" },
      ]}
    />
  );
}
