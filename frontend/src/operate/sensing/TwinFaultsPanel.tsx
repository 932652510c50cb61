import { useEffect, useRef, useState } from "react";
import { NativeSelect } from "@mantine/core";
import { usePage } from "../../live/page";
import { ControlButton } from "../ControlButton";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { rounded } from "../../ui/format";
import { NumberField } from "../../ui/numbers/NumberField";
import { useService } from "../../ui/services";
import { ALL_RODS, FAULTY_RODS } from "./rods";
import { twin, type TwinFaults } from "./twinFaults";
import { CHAMBERS } from "../../live/telemetry";

const OFF: TwinFaults = {
  noise: 0,
  sample_loss: 0,
  marker_loss: 0,
  rods: ALL_RODS,
  jump: [0, 0],
  freeze: 0,
  sensors_stuck: 0,
  valves_stuck: 0,
  supply_lost: false,
};

interface Fault {
  readonly name: "noise" | "sample_loss" | "marker_loss";
  readonly label: string;
  readonly unit: string;
  /** From SI to the display unit. */
  readonly scale: number;
  readonly max: number;
  readonly step: number;
}

const FAULTS: readonly Fault[] = [
  { name: "noise", label: "Noise", unit: "mm", scale: 1e3, max: 20, step: 0.5 },
  { name: "sample_loss", label: "Samples lost", unit: "%", scale: 100, max: 100, step: 5 },
  { name: "marker_loss", label: "Markers lost", unit: "%", scale: 100, max: 100, step: 5 },
];

/** What is broken in the twin, live: markers, pressure sensors, valves, supply. */
export function TwinFaultsPanel() {
  const operations = useService(Operations);
  const boot = usePage((page) => page.rig?.boot ?? 0);
  const mine = usePage((page) => page.lease.mine);
  const [faults, setFaults] = useState(OFF);
  useEffect(() => {
    // What is injected lives in the rig: asked for again with every life of it, and when control changes hands.
    let current = true;
    void operations.attempt("Injected faults not known", async () => {
      const found = await twin.faults();
      if (current) setFaults(found);
    });
    return () => {
      current = false;
    };
  }, [operations, boot, mine]);
  const inject = useInjecting(faults, setFaults);
  return (
    <fieldset className="faults" data-testid="faults">
      <legend>Inject into the twin</legend>
      {FAULTS.map((fault) => (
        <FaultField key={fault.name} fault={fault} value={faults[fault.name]} inject={inject} />
      ))}
      <FaultChoices faults={faults} inject={inject} />
      <ControlButton
        control="settings"
        variant="default"
        testId="faults-off"
        meaning="The twin as it was"
        onClick={() => inject(OFF)}
      >
        Off
      </ControlButton>
    </fieldset>
  );
}

/** One change after the other, each of what the twin had after the one before: none takes back another. */
function useInjecting(faults: TwinFaults, setFaults: (now: TwinFaults) => void): Inject {
  const operations = useService(Operations);
  const newest = useRef(faults);
  useEffect(() => {
    newest.current = faults;
  }, [faults]);
  return (change) => {
    const send = async () => {
      newest.current = await twin.inject({ ...newest.current, ...change });
      setFaults(newest.current);
    };
    void operations.attemptInTurn("Faults not injected", send);
  };
}

interface FieldProps {
  readonly fault: Fault;
  readonly value: number;
  readonly inject: Inject;
}

function FaultField({ fault, value, inject }: FieldProps) {
  const { name, label, unit, scale, max, step } = fault;
  const reason = useWhyNot("settings");
  return (
    <NumberField
      w={98}
      label={`${label}, ${unit}`}
      testId={`fault-${name}`}
      value={rounded(value * scale)}
      min={0}
      max={max}
      step={step}
      clampBehavior="strict"
      hint={`0 … ${max} ${unit}`}
      reason={reason}
      send={(wanted) => inject({ [name]: wanted / scale })}
    />
  );
}

type Inject = (change: Partial<TwinFaults>) => void;

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
function FaultChoices({ faults, inject }: Props) {
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
