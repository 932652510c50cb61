import { NumberInput, Tooltip, type NumberInputProps } from "@mantine/core";
import { typedNumber, useTyped } from "./typed";

interface Props extends Pick<NumberInputProps, "aria-label" | "clampBehavior" | "label" | "step" | "w"> {
  /** What is in force. */
  readonly value: number;
  readonly min: number;
  readonly max: number;
  readonly testId: string;
  /** Shown on hover while it may be changed. */
  readonly hint?: string;
  /** Why it may not be changed. */
  readonly reason?: string | null;
  readonly send: (value: number) => Promise<void> | void;
}

/** A live number: what is typed is sent on Enter or when the field is left, and what is in force stands there after. */
export function NumberField({ value, min, max, testId, hint, reason = null, send, ...input }: Props) {
  const { typed, setTyped, drop } = useTyped();
  const wanted = typed === null ? null : typedNumber(typed);
  const wrong = wanted !== null && (wanted < min || wanted > max);
  const leave = async () => {
    if (wanted !== null && wanted !== value) await send(wanted);
    drop();
  };
  const field = (
    <NumberInput
      size="xs"
      className="number-field"
      clampBehavior="none"
      {...input}
      data-testid={testId}
      readOnly={reason !== null}
      aria-disabled={reason !== null}
      value={typed ?? value}
      min={min}
      max={max}
      error={wrong}
      onChange={setTyped}
      onBlur={() => void leave()}
      onKeyDown={(event) => {
        if (event.key === "Enter") void leave();
      }}
    />
  );
  if (hint === undefined) return field;
  return (
    <Tooltip label={reason ?? hint} openDelay={reason === null ? 300 : 0}>
      {field}
    </Tooltip>
  );
}
