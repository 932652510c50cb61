import { Button, Tooltip, VisuallyHidden, type ButtonProps } from "@mantine/core";
import { useId, type ReactNode } from "react";
import { useWhyNot, type Control } from "./permission";

interface Props extends Omit<ButtonProps, "disabled"> {
  readonly control: Control;
  /** Another reason why it does not work now. */
  readonly because?: string | null;
  readonly onClick: () => void;
  /** What it does, shown when it is allowed. */
  readonly meaning: string;
  readonly testId: string;
  readonly children: ReactNode;
}

/** A button that says why when it is not allowed: on hover and to a screen reader. */
export function ControlButton({
  control,
  because = null,
  onClick,
  meaning,
  testId,
  children,
  ...button
}: Props) {
  const reason = useWhyNot(control) ?? because;
  const id = useId();
  const blocked = reason !== null;
  return (
    <Tooltip label={reason ?? meaning} position="bottom" openDelay={blocked ? 0 : 500}>
      <Button
        size="xs"
        {...button}
        data-testid={testId}
        data-disabled={blocked}
        aria-disabled={blocked}
        aria-describedby={id}
        onClick={() => {
          if (!blocked) onClick();
        }}
      >
        {children}
        <VisuallyHidden id={id}>{reason ?? meaning}</VisuallyHidden>
      </Button>
    </Tooltip>
  );
}
