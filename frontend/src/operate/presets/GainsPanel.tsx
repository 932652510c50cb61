import { NativeSelect, Slider, Tooltip } from "@mantine/core";
import { useState } from "react";
import type { Law, Settings } from "../../api/types";
import { usePage } from "../../live/page";
import { ControlButton } from "../ControlButton";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { SettingField } from "../SettingField";
import {
  boundsText,
  defaultGains,
  limits,
  OPEN_LOOP,
  PAIRS,
  SCALARS,
  type PairName,
  type ScalarName,
  type Shown,
} from "../settings";
import { LAW_TEXT } from "../../live/modes";
import { rounded } from "../../ui/format";
import { useService } from "../../ui/services";
import { ControllerChoice } from "./ControllerChoice";
import { FirstMode } from "./FirstMode";
import { GainPresets } from "./GainPresets";

const OPEN: Law = 0;
const LAWS: readonly Law[] = [4, 3, 2, 1, 0];
/** Of no effect where a controller has gains of its own. */
const PAPER_GAINS = new Set<PairName>(["K_P", "K_I", "K_FF"]);
const AXES = ["x", "y"] as const;

/** Law, gains and limits as the rig has them; every change is sent at once. */
export function GainsPanel() {
  const settings = usePage((page) => page.settings);
  const own = usePage((page) => page.rig?.controllers[settings?.controller ?? 0]?.own_gains === true);
  const measuring = usePage((page) => page.firstMode?.state === "running");
  const operations = useService(Operations);
  if (!settings) return <p className="panel note">Waiting for the settings.</p>;
  return (
    <div className="panel">
      <div className="row">
        <LawSelect law={settings.law} />
        <ControlButton
          control="settings"
          variant="default"
          testId="gains-reset"
          meaning="Put law, gains and limits back to their defaults"
          onClick={() => void operations.changeSettings("Gains not reset", defaultGains())}
        >
          Reset to defaults
        </ControlButton>
        <GainPresets />
      </div>
      <ControllerChoice settings={settings} />
      {settings.law === OPEN && !measuring ? <OpenLoop settings={settings} /> : null}
      <div className="gains">
        <div className="gain-table">
          <span />
          <span className="gain-head">x</span>
          <span className="gain-head">y</span>
          {PAIRS.filter(({ name }) => !own || !PAPER_GAINS.has(name)).map((shown) => (
            <PairRow key={shown.name} shown={shown} value={settings[shown.name]} />
          ))}
        </div>
        <div className="gain-table gain-scalars">
          {SCALARS.map((shown) => (
            <ScalarRow key={shown.name} shown={shown} value={settings[shown.name]} />
          ))}
        </div>
      </div>
      <FirstMode />
    </div>
  );
}

function LawSelect({ law }: { readonly law: Law }) {
  const operations = useService(Operations);
  const reason = useWhyNot("settings");
  return (
    <Tooltip label={reason ?? "Which terms make the command"} openDelay={reason === null ? 500 : 0}>
      <NativeSelect
        size="xs"
        aria-label="Law"
        data-testid="law"
        disabled={reason !== null}
        value={String(law)}
        data={LAWS.map((value) => ({ value: String(value), label: LAW_TEXT[value] }))}
        onChange={(event) => {
          const chosen = LAWS.find((value) => String(value) === event.currentTarget.value);
          if (chosen !== undefined) void operations.changeSettings("Law not changed", { law: chosen });
        }}
      />
    </Tooltip>
  );
}

/** What it is, its symbol in the paper, and its bounds. */
function Name({ shown }: { readonly shown: Shown<PairName | ScalarName> }) {
  const rig = usePage((page) => page.rig);
  const [base, index] = shown.label.split("_");
  return (
    <span className="gain-name">
      {shown.meaning}
      <span className="bounds">
        <span className="symbol">
          {base}
          {index ? <sub>{index}</sub> : null}
        </span>{" "}
        {boundsText(shown, rig)}
      </span>
    </span>
  );
}

interface PairRowProps {
  readonly shown: Shown<PairName>;
  readonly value: readonly [number, number];
}

function PairRow({ shown, value }: PairRowProps) {
  const { name, label, unit, scale, step } = shown;
  const rig = usePage((page) => page.rig);
  return (
    <>
      <Name shown={shown} />
      {AXES.map((axis, i) => (
        <SettingField
          key={axis}
          label={`${label} ${axis}`}
          testId={`${name}-${axis}`}
          value={rounded(value[i] * scale)}
          step={step}
          unit={unit}
          {...limits(shown, rig)}
          change={(wanted, now) => ({ [name]: now[name].map((old, j) => (j === i ? wanted / scale : old)) })}
        />
      ))}
    </>
  );
}

function ScalarRow({ shown, value }: { readonly shown: (typeof SCALARS)[number]; readonly value: number }) {
  const { name, meaning, unit, scale, step } = shown;
  return (
    <>
      <Name shown={shown} />
      <SettingField
        label={meaning}
        testId={name}
        value={rounded(value * scale)}
        step={step}
        unit={unit}
        {...limits(shown)}
        change={(wanted) => ({ [name]: wanted / scale })}
      />
    </>
  );
}

/** The two moments of the open-loop law, sent when a slider is let go. */
function OpenLoop({ settings }: { readonly settings: Settings }) {
  const torque = usePage((page) => page.rig?.parameters.actuator.u_max ?? 0.06);
  return (
    <div className="open-loop">
      {settings.u_open.map((value, i) => (
        <TorqueSlider key={i} index={i} value={value} torque={torque} />
      ))}
    </div>
  );
}

interface TorqueProps {
  readonly index: number;
  readonly value: number;
  readonly torque: number;
}

function TorqueSlider({ index, value, torque }: TorqueProps) {
  const operations = useService(Operations);
  const reason = useWhyNot("settings");
  const { scale, step, unit, meaning } = OPEN_LOOP;
  const [draft, setDraft] = useState<number | null>(null);
  const send = async (wanted: number) => {
    await operations.changeSettings("Command not changed", ({ u_open: [first, second] }) => ({
      u_open: index === 0 ? [wanted / scale, second] : [first, wanted / scale],
    }));
    setDraft((now) => (now === wanted ? null : now));
  };
  return (
    <Tooltip label={reason ?? `${meaning} ${index === 0 ? "of the rear pair" : "of the top pair"}`}>
      <div className="torque">
        <span className="symbol">
          u<sub>{index + 1}</sub>
        </span>
        <Slider
          className="torque-slider"
          size="sm"
          disabled={reason !== null}
          value={draft ?? value * scale}
          min={-torque * scale}
          max={torque * scale}
          step={step}
          marks={[{ value: 0 }]}
          label={(shown) => `${shown.toFixed(1)} ${unit}`}
          thumbLabel={`u ${index + 1}`}
          onChange={setDraft}
          onChangeEnd={(wanted) => void send(wanted)}
        />
        <span className="number unit">{`${(value * scale).toFixed(1)} ${unit}`}</span>
      </div>
    </Tooltip>
  );
}
