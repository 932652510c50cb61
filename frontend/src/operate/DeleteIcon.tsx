import { ActionIcon, Tooltip } from "@mantine/core";
import { IconTrash } from "@tabler/icons-react";
import { useState } from "react";
import { useWhyNot, type Control } from "./permission";

interface Props {
  readonly control: Control;
  readonly name: string;
  readonly testId: string;
  readonly onDelete: () => void;
}

/** Asks once more before it deletes. */
export function DeleteIcon({ control, name, testId, onDelete }: Props) {
  const [sure, setSure] = useState(false);
  const reason = useWhyNot(control);
  const label = reason ?? (sure ? `Really delete ${name}?` : `Delete ${name}`);
  return (
    <Tooltip label={label}>
      <ActionIcon
        variant={sure ? "filled" : "subtle"}
        color={sure ? "red" : "gray"}
        aria-label={label}
        aria-disabled={reason !== null}
        data-disabled={reason !== null}
        data-testid={testId}
        onBlur={() => setSure(false)}
        onClick={() => {
          if (reason !== null) return;
          if (sure) onDelete();
          setSure(!sure);
        }}
      >
        <IconTrash size={16} />
      </ActionIcon>
    </Tooltip>
  );
}
