import { ActionIcon, Popover } from "@mantine/core";
import { useState, type ReactNode } from "react";

interface Props {
  /** What is chosen in it, and its heading. */
  readonly title: string;
  /** What is in force now; it ends the button's name. */
  readonly state: string;
  readonly icon: ReactNode;
  readonly testId: string;
  readonly children: (close: () => void) => ReactNode;
}

/** A button of the header that opens a few choices; by keys the focus goes into them, and back. */
export function HeaderPopover({ title, state, icon, testId, children }: Props) {
  const [opened, setOpened] = useState(false);
  return (
    <Popover
      opened={opened}
      onChange={setOpened}
      position="bottom-end"
      shadow="md"
      width={300}
      trapFocus
      returnFocus
    >
      <Popover.Target>
        <ActionIcon
          variant="subtle"
          color="gray"
          aria-label={`${title}: ${state}`}
          title={title}
          data-testid={testId}
          onClick={() => setOpened(!opened)}
        >
          {icon}
        </ActionIcon>
      </Popover.Target>
      <Popover.Dropdown p={12} className="panel" aria-label={title}>
        <h2 className="bar-title">{title}</h2>
        {children(() => {
          setOpened(false);
        })}
      </Popover.Dropdown>
    </Popover>
  );
}
