import { NativeSelect } from "@mantine/core";
import { useWhyNot } from "../permission";
import { CHAMBERS } from "../../live/telemetry";
import { FAULTY_RODS } from "./rods";
import type { TwinFaults } from "./twinFaults";

export type Inject = (change: Partial<TwinFaults>) => void;

/** One of several states of the twin: its name in the menu, and what it changes. */
type Option = readonly [name: string, change: Partial<TwinFaults>];

interface Choice {
  readonly label: string;
  readonly testId: string;
  readonly options: readonly Option[];
}

const JUMPS_MM = [0, 20, 50, 100];

/** None, each chamber alone, all four. */
function chambers(key: "sensors_stuck" | "valves_stuck"): readonly Option[] {
  return [
    ["none", { [key]: 0 }],
    ...CHAMBERS.map((name, i) => [name, { [key]: 1 << i }] as const),
    ["all", { [key]: 15 }],
  ];
}

const CHOICES: readonly Choice[] = [
  {
    label: "Noise, loss on",
    testId: "fault-rods",
    options: FAULTY_RODS.map(([name, rods]) => [name, { rods }] as const),
  },
  {
    label: "Markers jump",
    testId: "fault-jump",
    options: JUMPS_MM.map((mm) => [mm === 0 ? "no" : `${mm} mm up`, { jump: [0, mm / 1e3] }] as const),
  },
  {
    label: "Markers frozen",
    testId: "fault-freeze",
    options: [
      ["no", { freeze: 0 }],
      ["old time", { freeze: 1 }],
      ["fresh time", { freeze: 2 }],
    ],
  },
  { label: "Sensor stuck", testId: "fault-sensors", options: chambers("sensors_stuck") },
  { label: "Valve stuck", testId: "fault-valves", options: chambers("valves_stuck") },
  {
    label: "Supply",
    testId: "fault-supply",
    options: [
      ["there", { supply_lost: false }],
      ["lost", { supply_lost: true }],
    ],
  },
];

interface Props {
  readonly faults: TwinFaults;
  readonly inject: Inject;
}

/** Menus of what is whole or broken. */
export function FaultChoices({ faults, inject }: Props) {
  const reason = useWhyNot("settings");
  return CHOICES.map(({ label, testId, options }) => (
    <NativeSelect
      key={testId}
      size="xs"
      w={98}
      label={label}
      data-testid={testId}
      disabled={reason !== null}
      value={options.find(([, change]) => holds(faults, change))?.[0] ?? ""}
      data={options.map(([name]) => name)}
      onChange={(event) => {
        const chosen = options.find(([name]) => name === event.currentTarget.value);
        if (chosen) inject(chosen[1]);
      }}
    />
  ));
}

/** Whether everything in `change` is in force. */
function holds(faults: TwinFaults, change: Partial<TwinFaults>): boolean {
  const now: Partial<TwinFaults> = { ...faults, ...change };
  return JSON.stringify(now) === JSON.stringify(faults);
}
