import { Button, Popover } from "@mantine/core";
import { IconTrash } from "@tabler/icons-react";
import { useRef, useState } from "react";
import type { Recording } from "../../api/types";

interface Props {
  readonly row: Recording;
  readonly running: boolean;
  /** Why nothing can be changed, null when it can. */
  readonly reason: string | null;
  readonly onDelete: () => Promise<void>;
}

/** Deletes into the bin; a starred recording and the one being written are kept. The question is made when it is asked. */
export function DeleteButton({ row, running, reason, onDelete }: Props) {
  const [opened, setOpened] = useState(false);
  const returns = useRef(false);
  const turn = (to: boolean) => {
    returns.current = !to;
    setOpened(to);
  };
  const button = (
    <button
      ref={(shown) => {
        if (!returns.current) return;
        returns.current = false;
        shown?.focus({ preventScroll: true });
      }}
      type="button"
      className="icon-button"
      aria-haspopup="dialog"
      aria-expanded={opened}
      aria-label={`Delete ${row.name || row.id}`}
      data-testid="delete-recording"
      onClick={() => turn(!opened)}
    >
      <IconTrash size={16} />
    </button>
  );
  if (!opened) return button;
  const kept = reason ?? whyKept(row, running);
  return (
    <Popover opened onChange={turn} position="bottom-end" shadow="md" trapFocus withinPortal>
      <Popover.Target>{button}</Popover.Target>
      <Popover.Dropdown aria-label="Delete the recording?">
        <p className="note">{kept ?? "It can be restored for 7 days."}</p>
        <Button
          size="compact-sm"
          mt={6}
          color="red"
          data-testid="delete-confirm"
          disabled={kept !== null}
          onClick={() => {
            setOpened(false);
            void onDelete();
          }}
        >
          Delete
        </Button>
      </Popover.Dropdown>
    </Popover>
  );
}

function whyKept({ starred }: Recording, running: boolean): string | null {
  if (running) return "It is being recorded: stop first.";
  return starred ? "It is starred: take the star away first." : null;
}
