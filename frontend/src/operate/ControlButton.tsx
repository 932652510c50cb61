import { Button, Tooltip, VisuallyHidden, type ButtonProps } from "@mantine/core";
import { useEffect, useId, useState, type ReactNode } from "react";
import { useWhyNot, type Control } from "./permission";

/** How long a button that took another one's place takes no press: so soon no one has read it [ms]. */
const UNREAD_MS = 500;

interface Props extends Omit<ButtonProps, "disabled"> {
  readonly control: Control;
  /** Another reason why it does not work now. */
  readonly because?: string | null;
  readonly onClick: () => void;
  /** What it does, shown when it is allowed. */
  readonly meaning: string;
  /** It comes where another button was, perhaps under a finger: what it does is not said before a mouse moves on it. */
  readonly replaces?: boolean;
  /** The same, and a double click there must not press it, too. */
  readonly waits?: boolean;
  readonly testId: string;
  readonly children: ReactNode;
}

/** A button that says why when it is not allowed: on hover and to a screen reader. */
export function ControlButton({
  control,
  because = null,
  onClick,
  meaning,
  waits = false,
  replaces = waits,
  testId,
  children,
  ...button
}: Props) {
  const reason = useWhyNot(control) ?? because;
  const id = useId();
  const blocked = reason !== null;
  const unread = useUnread(waits);
  const [unhovered, setUnhovered] = useState(replaces);
  const [pressed, setPressed] = useState(false);
  return (
    <Tooltip
      label={reason ?? meaning}
      position="bottom"
      openDelay={blocked ? 0 : 500}
      disabled={unhovered || pressed}
    >
      <Button
        size="xs"
        {...button}
        data-testid={testId}
        data-disabled={blocked}
        aria-disabled={blocked}
        aria-describedby={id}
        data-unread={unread || undefined}
        onMouseMove={() => setUnhovered(false)}
        onMouseLeave={() => setPressed(false)}
        onClick={() => {
          if (blocked || unread) return;
          setPressed(true);
          onClick();
        }}
      >
        {children}
        <VisuallyHidden id={id}>{reason ?? meaning}</VisuallyHidden>
      </Button>
    </Tooltip>
  );
}

/** For UNREAD_MS after it came. */
function useUnread(waits: boolean): boolean {
  const [unread, setUnread] = useState(waits);
  useEffect(() => {
    const read = setTimeout(() => setUnread(false), UNREAD_MS);
    return () => {
      clearTimeout(read);
    };
  }, []);
  return unread;
}
