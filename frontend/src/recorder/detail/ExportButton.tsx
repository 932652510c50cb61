import { Button } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { useState } from "react";
import type { Recording } from "../../api/types";
import type { TimeWindow } from "../quick/QuickPlot";
import { ExportDialog } from "./ExportDialog";

interface Props {
  readonly recording: Recording;
  readonly zoomed: TimeWindow | null;
}

/** The recording as a file of another program. */
export function ExportButton({ recording, zoomed }: Props) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <Button
        size="compact-sm"
        variant="default"
        leftSection={<IconDownload size={14} />}
        data-testid="export"
        onClick={() => {
          setOpen(true);
        }}
      >
        Export
      </Button>
      {open ? (
        <ExportDialog
          recording={recording}
          zoomed={zoomed}
          onClose={() => {
            setOpen(false);
          }}
        />
      ) : null}
    </>
  );
}
