import { Button, Popover } from "@mantine/core";
import { IconAdjustments } from "@tabler/icons-react";
import { ALARM_BOUNDS } from "../api/bounds";
import type { AlarmLimits } from "../api/types";
import { usePage } from "../live/page";
import { rounded } from "../ui/format";
import { NumberField } from "../ui/numbers/NumberField";
import { useService } from "../ui/services";
import { Alarms } from "./alarms";
import type { Alarm, Limits } from "./health";

interface Shown {
  readonly alarm: Alarm;
  readonly name: string;
  readonly unit: string;
  /** From SI to the display unit. */
  readonly scale: number;
  readonly step: number;
}

const ALARMS: readonly Shown[] = [
  { alarm: "on_time", name: "on time, below", unit: "%", scale: 100, step: 0.1 },
  { alarm: "lost_ticks", name: "lost ticks, above", unit: "in 1 min", scale: 1, step: 10 },
  { alarm: "lateness_p99", name: "lateness p99, above", unit: "ms", scale: 1e3, step: 0.1 },
  { alarm: "round_trip", name: "round trip, above", unit: "ms", scale: 1e3, step: 10 },
  { alarm: "command_age", name: "command age, above", unit: "ms", scale: 1e3, step: 50 },
  { alarm: "residual", name: "residual, above", unit: "mm", scale: 1e3, step: 1 },
];
const COLOURS = ["amber", "red"] as const;

/** From where on the figures are amber and red for me; kept on the server. */
export function HealthLimits() {
  const stored = useService(Alarms);
  const alarms = usePage((page) => page.alarms);
  if (!alarms) return null;
  return (
    <Popover position="top-end" shadow="md" trapFocus>
      <Popover.Target>
        <Button
          size="xs"
          variant="default"
          leftSection={<IconAdjustments size={15} />}
          data-testid="alarm-limits"
        >
          Limits
        </Button>
      </Popover.Target>
      <Popover.Dropdown className="limits" aria-label="Limits of the health figures">
        <table>
          <thead>
            <tr>
              <td />
              <th scope="col">amber</th>
              <th scope="col">red</th>
              <td />
            </tr>
          </thead>
          <tbody>
            {ALARMS.map((shown) => (
              <Row key={shown.alarm} shown={shown} alarms={alarms} />
            ))}
          </tbody>
        </table>
        <p className="note">Yours alone. While you operate, the log says when a figure turns red.</p>
        <Button size="xs" variant="default" data-testid="alarm-reset" onClick={() => void stored.reset()}>
          Defaults
        </Button>
      </Popover.Dropdown>
    </Popover>
  );
}

function Row({ shown, alarms }: { readonly shown: Shown; readonly alarms: AlarmLimits }) {
  return (
    <tr>
      <th scope="row">{shown.name}</th>
      {COLOURS.map((colour) => (
        <td key={colour}>
          <LimitField shown={shown} alarms={alarms} colour={colour} />
        </td>
      ))}
      <td className="unit">{shown.unit}</td>
    </tr>
  );
}

interface FieldProps {
  readonly shown: Shown;
  readonly alarms: AlarmLimits;
  readonly colour: keyof Limits;
}

/** What the server refuses is put back, with its reason in a notice. */
function LimitField({ shown: { alarm, name, unit, scale, step }, alarms, colour }: FieldProps) {
  const stored = useService(Alarms);
  const { minimum, maximum } = ALARM_BOUNDS[alarm];
  const keep = (value: number) =>
    stored.keep(`Limit of ${alarm} not changed`, (now) => ({
      ...now,
      [alarm]: { ...now[alarm], [colour]: value / scale },
    }));
  return (
    <NumberField
      w={92}
      aria-label={`${name}, ${colour} [${unit}]`}
      testId={`limit-${alarm}-${colour}`}
      value={rounded(alarms[alarm][colour] * scale)}
      min={rounded(minimum * scale)}
      max={rounded(maximum * scale)}
      step={step}
      send={keep}
    />
  );
}
