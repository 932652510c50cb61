import { Button, Group, Modal } from "@mantine/core";

interface Props {
  /** Name of the actuator, or of its file; null: nothing is asked. */
  readonly wanted: string | null;
  readonly onClose: () => void;
  readonly onYes: () => void;
}

/** Asks before the rig is ended and started again; the page stays in sight. */
export function AskActuator({ wanted, onClose, onYes }: Props) {
  return (
    <Modal
      opened={wanted !== null}
      onClose={onClose}
      title={`Start the rig again with ${wanted ?? ""}?`}
      size="sm"
      centered
      withOverlay={false}
      lockScroll={false}
      closeButtonProps={{ "aria-label": "Leave the actuator as it is" }}
    >
      <p className="note">
        For a few seconds there is no rig: nothing moves, nothing is shown. It comes back vented, for everyone
        who watches.
      </p>
      <Group justify="flex-end" mt="md">
        <Button size="xs" variant="default" onClick={onClose}>
          Cancel
        </Button>
        <Button size="xs" data-testid="actuator-confirm" data-autofocus onClick={onYes}>
          Start again
        </Button>
      </Group>
    </Modal>
  );
}
