import { FileButton } from "@mantine/core";
import { IconFileImport } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import { ToolButton } from "../../ui/buttons/ToolButton";
import { ImportDialog } from "./ImportDialog";

/** A CSV or SVG file becomes a drawing: chosen by this button, or dropped on the page; a dialog shows it first. */
export function DrawImport() {
  const [chosen, setChosen] = useState<{ readonly file: File; readonly count: number } | null>(null);
  const again = useRef<() => void>(null);
  const choose = (file: File | null) => {
    again.current?.(); // the same file may be chosen once more, mended
    if (file) setChosen((before) => ({ file, count: (before?.count ?? 0) + 1 }));
  };
  useEffect(() => {
    const allow = (event: DragEvent) => {
      event.preventDefault();
    };
    const drop = (event: DragEvent) => {
      event.preventDefault();
      choose(event.dataTransfer?.files.item(0) ?? null);
    };
    window.addEventListener("dragover", allow);
    window.addEventListener("drop", drop);
    return () => {
      window.removeEventListener("dragover", allow);
      window.removeEventListener("drop", drop);
    };
  }, []);
  const label = "Import a table (CSV: x, y or t, x, y) or an SVG drawing; or drop the file here";
  return (
    <>
      <FileButton
        accept=".csv,.txt,.tsv,.dat,.svg,text/csv,text/plain,image/svg+xml"
        resetRef={again}
        inputProps={{ "aria-label": "File to import" }}
        onChange={choose}
      >
        {(button) => (
          <ToolButton {...button} label={label} testId="tool-import">
            <IconFileImport size={18} />
          </ToolButton>
        )}
      </FileButton>
      {chosen ? (
        <ImportDialog
          key={chosen.count}
          file={chosen.file}
          onClose={() => {
            setChosen(null);
          }}
        />
      ) : null}
    </>
  );
}
