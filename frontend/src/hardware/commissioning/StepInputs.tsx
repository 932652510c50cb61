import { NumberInput } from "@mantine/core";
import { usePage, type Page } from "../../live/page";
import { useWhyNot } from "../../operate/permission";
import { INPUTS, mostOf, type Input, type StepName, type TypedInputs } from "./steps";

interface Props {
  readonly step: StepName;
  readonly typed: TypedInputs;
  readonly type: (typed: TypedInputs) => void;
}

/** With what a step begins; what is left empty is as usual. */
export function StepInputs({ step, typed, type }: Props) {
  const reason = useWhyNot("settings");
  const full = usePage(fullPressure);
  const inputs = INPUTS[step];
  if (inputs.length === 0) return null;
  return (
    <div className="row row-fields">
      {inputs.map((input) => (
        <NumberInput
          key={input.name}
          size="xs"
          w={150}
          className="number-field"
          label={labelOf(input, mostOf(input, full))}
          placeholder="as usual"
          data-testid={`input-${step}-${input.name}`}
          value={typed[input.name] ?? (input.usual === null ? "" : Math.round(input.usual * input.scale))}
          min={input.min}
          max={mostOf(input, full)}
          step={input.step}
          clampBehavior="blur"
          allowDecimal={input.unit !== ""}
          readOnly={reason !== null}
          onChange={(value) => type({ ...typed, [input.name]: value })}
        />
      ))}
    </div>
  );
}

/** At full torque, in the pair that takes less [Pa]. */
function fullPressure({ rig }: Page): number {
  const actuator = rig?.parameters.actuator;
  return actuator ? actuator.u_max * Math.min(...actuator.pressure_map) : Infinity;
}

function labelOf({ label, unit, min }: Input, max: number): string {
  return `${label}, ${min} … ${max}${unit === "" ? "" : ` ${unit}`}`;
}
