import { NativeSelect, TextInput } from "@mantine/core";
import { useEffect, useState } from "react";
import type { MacroStep } from "../../api/types";
import { SavedDrawings } from "../../drawing/saved";
import { usePage } from "../../live/page";
import { presets } from "../../operate/presets/presets";
import { rounded } from "../../ui/format";
import { NumberField } from "../../ui/numbers/NumberField";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";

interface Props<S extends MacroStep = MacroStep> {
  readonly step: S;
  readonly change: (step: MacroStep) => void;
}

/** What a step of this kind takes. */
export function StepFields({ step, change }: Props) {
  switch (step.do) {
    case "reference":
      return <References step={step} change={change} />;
    case "drawing":
      return <Drawings step={step} change={change} />;
    case "preset":
      return <Presets step={step} change={change} />;
    case "target":
      return (
        <>
          <Millimetres label="x" value={step.x} send={(x) => change({ ...step, x })} />{" "}
          {/* prettier-ignore */}
          <Millimetres label="y" value={step.y} send={(y) => change({ ...step, y })} />{" "}
          {/* prettier-ignore */}
        </>
      );
    case "wait":
      return (
        <span className="limit">
          <NumberField
            aria-label="Time to wait"
            testId="step-seconds"
            value={step.seconds}
            min={0.1}
            max={3600}
            send={(seconds) => change({ ...step, seconds })}
          />
          <span className="unit">s</span>
        </span>
      );
    case "record":
      return <Words label="Name of the recording" value={step.name} send={(name) => change({ ...step, name })} />; // prettier-ignore
    case "mark":
      return <Words label="Label of the bookmark" value={step.label} send={(label) => change({ ...step, label })} />; // prettier-ignore
    case "arm":
    case "hold":
    case "clear":
    case "run_end":
    case "record_end":
      return null;
  }
}

function References({ step, change }: Props<Extract<MacroStep, { do: "reference" }>>) {
  const names = usePage((page) => page.references).map(({ name, title }) => ({ value: name, label: title }));
  return <Followed label="Reference" names={names} step={step} change={change} />;
}

function Drawings({ step, change }: Props<Extract<MacroStep, { do: "drawing" }>>) {
  const list = useStore(useService(SavedDrawings).store, (state) => state.list);
  const names = list.map(({ name }) => ({ value: name, label: name }));
  return <Followed label="Drawing" names={names} step={step} change={change} />;
}

type FollowStep = Extract<MacroStep, { do: "reference" | "drawing" }>;
type FollowedProps = Props<FollowStep> & Pick<ChoiceProps, "label" | "names">;

/** What is followed, and how often. */
function Followed({ label, names, step, change }: FollowedProps) {
  return (
    <>
      <Choice label={label} value={step.name} names={names} send={(name) => change({ ...step, name })} />{" "}
      {/* prettier-ignore */}
      <Laps value={step.laps} send={(laps) => change({ ...step, laps })} /> {/* prettier-ignore */}
    </>
  );
}

function Presets({ step, change }: Props<Extract<MacroStep, { do: "preset" }>>) {
  const [names, setNames] = useState<readonly Named[]>([]);
  useEffect(() => {
    presets.gains().then(
      (found) => { setNames(found.map(({ name }) => ({ value: name, label: name }))); }, // prettier-ignore
      () => undefined, // what is chosen stays
    );
  }, []);
  return <Choice label="Preset of gains" value={step.name} names={names} send={(name) => change({ ...step, name })} />; // prettier-ignore
}

interface Named {
  readonly value: string;
  readonly label: string;
}

interface ChoiceProps {
  readonly label: string;
  readonly value: string;
  readonly names: readonly Named[];
  readonly send: (value: string) => void;
}

/** One of `names`; what was chosen stays in sight when it is gone. */
function Choice({ label, value, names, send }: ChoiceProps) {
  const gone = value === "" || names.every((name) => name.value !== value);
  const first = value === "" ? "choose" : value;
  return (
    <NativeSelect
      size="xs"
      aria-label={label}
      data-testid="step-name"
      data={[...(gone ? [{ value, label: first }] : []), ...names]}
      value={value}
      onChange={(event) => send(event.currentTarget.value)}
    />
  );
}

function Laps({ value, send }: { readonly value: number; readonly send: (laps: number) => void }) {
  return (
    <span className="limit">
      <NumberField
        aria-label="Laps"
        testId="step-laps"
        value={value}
        min={1}
        max={1000}
        send={(laps) => send(Math.round(laps))}
      />
      <span className="unit">laps</span>
    </span>
  );
}

interface MillimetresProps {
  readonly label: string;
  /** [m] */
  readonly value: number;
  readonly send: (metres: number) => void;
}

function Millimetres({ label, value, send }: MillimetresProps) {
  return (
    <span className="limit">
      <span className="note">{label}</span>
      <NumberField
        aria-label={`Target ${label}`}
        testId={`step-${label}`}
        value={rounded(value * 1e3)}
        min={-2000}
        max={2000}
        send={(millimetres) => send(millimetres / 1e3)}
      />
      <span className="unit">mm</span>
    </span>
  );
}

interface WordsProps {
  readonly label: string;
  readonly value: string;
  readonly send: (text: string) => void;
}

function Words({ label, value, send }: WordsProps) {
  return (
    <TextInput
      size="xs"
      aria-label={label}
      placeholder={label}
      maxLength={80}
      data-testid="step-words"
      value={value}
      onChange={(event) => send(event.currentTarget.value)}
    />
  );
}
