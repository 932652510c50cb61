import { NumberInput, Tooltip } from "@mantine/core";
import { useState } from "react";
import type { Settings } from "../api/types";
import { useService } from "../ui/services";
import { Operations } from "./operations";
import { useWhyNot } from "./permission";

interface Props {
  readonly label: string;
  /** The rig's value, in the display unit. */
  readonly value: number;
  readonly min: number;
  readonly max: number;
  readonly step: number;
  readonly unit: string;
  readonly testId: string;
  /** The change to send for a value in the display unit. */
  readonly change: (value: number) => Partial<Settings>;
}

/** A live number: what is typed is sent on Enter or when the field is left, and what the rig has stands there after. */
export function NumberField({ label, value, min, max, step, unit, testId, change }: Props) {
  const operations = useService(Operations);
  const reason = useWhyNot("settings");
  const [draft, setDraft] = useState<number | string | null>(null);
  const wrong = typeof draft === "number" && (draft < min || draft > max);
  const send = async () => {
    const wanted = draft;
    if (typeof wanted === "number" && wanted !== value)
      await operations.changeSettings(`${label} not changed`, change(wanted));
    setDraft(null);
  };
  return (
    <Tooltip label={reason ?? `${min} … ${max} ${unit}`} openDelay={reason === null ? 300 : 0}>
      <NumberInput
        size="xs"
        className="number-field"
        aria-label={label}
        data-testid={testId}
        readOnly={reason !== null}
        aria-disabled={reason !== null}
        value={draft ?? value}
        min={min}
        max={max}
        step={step}
        clampBehavior="none"
        error={wrong}
        onChange={setDraft}
        onBlur={() => void send()}
        onKeyDown={(event) => {
          if (event.key === "Enter") void send();
        }}
      />
    </Tooltip>
  );
}
