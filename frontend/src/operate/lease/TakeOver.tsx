import { Button, Group, Modal } from "@mantine/core";
import type { Person } from "../../api/types";
import { useService } from "../../ui/services";
import { Operations } from "../operations";

interface Props {
  /** Whose control is to be taken; null: no one's. */
  readonly from: Person | null;
  readonly onClose: () => void;
}

/** Asks before control is taken from someone; the page stays in sight, as the rig goes on. */
export function TakeOver({ from, onClose }: Props) {
  const operations = useService(Operations);
  return (
    <Modal
      opened={from !== null}
      onClose={onClose}
      title={`Take control from ${from?.name ?? ""}?`}
      size="sm"
      centered
      withOverlay={false}
      lockScroll={false}
      closeButtonProps={{ "aria-label": "Leave control where it is" }}
    >
      <p className="note">
        The motion is held first. {from?.name} is told that you operate now, and it stands in the log.
      </p>
      <Group justify="flex-end" mt="md">
        <Button size="xs" variant="default" onClick={onClose}>
          Cancel
        </Button>
        <Button
          size="xs"
          color="red"
          data-testid="take-over-confirm"
          onClick={() => {
            if (from) void operations.takeOver(from.tag);
            onClose();
          }}
        >
          Take over
        </Button>
      </Group>
    </Modal>
  );
}
