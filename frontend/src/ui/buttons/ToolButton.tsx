import { ActionIcon, Tooltip } from "@mantine/core";
import type { ComponentProps } from "react";

interface Props extends Omit<ComponentProps<"button">, "color" | "style"> {
  /** What it does: its name, and what is shown on hover. */
  readonly label: string;
  readonly testId: string;
  readonly pressed?: boolean;
}

/** A button of a toolbar. Whatever else a menu or a popover tells its target reaches the button. */
export function ToolButton({ label, testId, pressed, disabled = false, onClick, ...others }: Props) {
  return (
    <Tooltip label={label} openDelay={300}>
      <ActionIcon
        {...others}
        size={30}
        variant={pressed === true ? "light" : "subtle"}
        color={pressed === true ? "blue" : "gray"}
        aria-label={label}
        aria-pressed={pressed}
        aria-disabled={disabled}
        data-disabled={disabled}
        data-testid={testId}
        onClick={disabled ? undefined : onClick}
      />
    </Tooltip>
  );
}
