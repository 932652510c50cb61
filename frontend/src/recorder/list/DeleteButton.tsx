import { ActionIcon, Button, Popover } from "@mantine/core";
import { IconTrash } from "@tabler/icons-react";
import { useState } from "react";
import type { Recording } from "../../api/types";
import { useWhyNot } from "../../operate/permission";

interface Props {
  readonly row: Recording;
  readonly running: boolean;
  readonly onDelete: () => Promise<void>;
}

/** Deletes into the bin; a starred recording and the one being written are kept. */
export function DeleteButton({ row, running, onDelete }: Props) {
  const [opened, setOpened] = useState(false);
  const reason =
    useWhyNot("edit") ??
    (running
      ? "It is being recorded: stop first."
      : row.starred
        ? "It is starred: take the star away first."
        : null);
  return (
    <Popover opened={opened} onChange={setOpened} position="bottom-end" shadow="md" trapFocus withinPortal>
      <Popover.Target>
        <ActionIcon
          variant="subtle"
          color="gray"
          aria-label={`Delete ${row.name || row.id}`}
          data-testid="delete-recording"
          onClick={() => {
            setOpened(!opened);
          }}
        >
          <IconTrash size={16} />
        </ActionIcon>
      </Popover.Target>
      <Popover.Dropdown aria-label="Delete the recording?">
        <p className="note">{reason ?? "It can be restored for 7 days, unless room is needed."}</p>
        <Button
          size="compact-sm"
          mt={6}
          color="red"
          data-testid="delete-confirm"
          disabled={reason !== null}
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
