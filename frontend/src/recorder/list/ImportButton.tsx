import { FileButton } from "@mantine/core";
import { IconFileImport } from "@tabler/icons-react";
import { useRef, useState } from "react";
import { readPath } from "../../drawing/readPath";
import { ControlButton } from "../../operate/ControlButton";
import { unitsMissing } from "../recordings";
import type { Recordings } from "../useRecordings";
import { ImportDialog, type Chosen } from "./ImportDialog";

/** Another lab's CSV file as a recording: choose it, say what its header does not, look at what came of it. */
export function ImportButton({ recordings }: { readonly recordings: Recordings }) {
  const [chosen, setChosen] = useState<Chosen | null>(null);
  const again = useRef<() => void>(null);
  const choose = async (file: File | null) => {
    again.current?.(); // the same file may be chosen once more, mended
    if (file) setChosen({ file, missing: unitsMissing(await readPath(file).catch(() => null)) });
  };
  return (
    <>
      <FileButton
        accept=".csv,.txt,text/csv"
        resetRef={again}
        inputProps={{ "aria-label": "CSV file to import as a recording" }}
        onChange={(file) => void choose(file)}
      >
        {({ onClick }) => (
          <ControlButton
            control="settings"
            size="compact-sm"
            variant="default"
            leftSection={<IconFileImport size={14} />}
            testId="import-recording"
            meaning="A CSV file with columns time, x, y becomes a recording"
            onClick={onClick}
          >
            Import CSV
          </ControlButton>
        )}
      </FileButton>
      {chosen ? (
        <ImportDialog
          key={`${chosen.file.name} ${chosen.file.lastModified}`}
          chosen={chosen}
          recordings={recordings}
          onClose={() => {
            setChosen(null);
          }}
        />
      ) : null}
    </>
  );
}
