import { NumberInput } from "@mantine/core";
import { useState } from "react";

interface Props {
  readonly label: string;
  readonly value: number;
  readonly min: number;
  readonly max: number;
  readonly step: number;
  readonly width: number;
  readonly testId: string;
  readonly onChange: (value: number) => void;
}

/** A number of the drawing: taken as soon as what is typed is one within its bounds. */
export function DrawNumber({ label, value, min, max, step, width, testId, onChange }: Props) {
  const [draft, setDraft] = useState<number | string | null>(null);
  const wrong = draft !== null && !(typeof draft === "number" && draft >= min && draft <= max);
  return (
    <NumberInput
      size="xs"
      className="number-field"
      w={width}
      label={label}
      data-testid={testId}
      value={draft ?? value}
      min={min}
      max={max}
      step={step}
      clampBehavior="none"
      error={wrong}
      onChange={(typed) => {
        setDraft(typed);
        if (typeof typed === "number" && typed >= min && typed <= max && typed !== value) onChange(typed);
      }}
      onBlur={() => {
        setDraft(null);
      }}
    />
  );
}
