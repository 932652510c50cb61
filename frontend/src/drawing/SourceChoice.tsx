import { SegmentedControl } from "@mantine/core";
import { useService } from "../ui/services";
import { Drawing, useDrawing } from "./drawing";

/** What to follow: a reference of the library, or the drawing. */
export function SourceChoice() {
  const drawing = useService(Drawing);
  const source = useDrawing((state) => state.source);
  return (
    <SegmentedControl
      size="xs"
      aria-label="What to follow"
      value={source}
      onChange={(value) => drawing.chooseSource(value === "drawing" ? "drawing" : "library")}
      data={[
        { value: "library", label: "Library" },
        { value: "drawing", label: "Drawing" },
      ]}
    />
  );
}
