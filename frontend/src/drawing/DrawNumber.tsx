import { NumberInput } from "@mantine/core";
import { typedNumber, useTyped } from "../ui/numbers/typed";

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
  const { typed, setTyped, drop } = useTyped();
  const isWithin = (wanted: number | null): wanted is number =>
    wanted !== null && wanted >= min && wanted <= max;
  return (
    <NumberInput
      size="xs"
      className="number-field"
      w={width}
      label={label}
      data-testid={testId}
      value={typed ?? value}
      min={min}
      max={max}
      step={step}
      clampBehavior="none"
      error={typed !== null && !isWithin(typedNumber(typed))}
      onChange={(now) => {
        setTyped(now);
        const wanted = typedNumber(now);
        if (isWithin(wanted) && wanted !== value) onChange(wanted);
      }}
      onBlur={() => drop()}
    />
  );
}
