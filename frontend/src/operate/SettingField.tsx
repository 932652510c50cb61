import type { Settings } from "../api/types";
import { NumberField } from "../ui/numbers/NumberField";
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
  readonly change: (value: number, now: Settings) => Partial<Settings>;
}

/** A setting of the rig as a number. */
export function SettingField({ label, unit, change, ...field }: Props) {
  const operations = useService(Operations);
  const reason = useWhyNot("settings");
  return (
    <NumberField
      {...field}
      aria-label={label}
      hint={`${field.min} … ${field.max} ${unit}`}
      reason={reason}
      send={(value) => operations.changeSettings(`${label} not changed`, (now) => change(value, now))}
    />
  );
}
