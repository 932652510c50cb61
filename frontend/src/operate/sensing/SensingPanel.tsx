import { Tooltip } from "@mantine/core";
import { Live } from "../../live/live";
import { usePage } from "../../live/page";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { DASH, plain } from "../../ui/format";
import { LiveText } from "../../ui/LiveText";
import { useService } from "../../ui/services";
import { isSensed, markersOf, missOf, residualOf } from "./residual";
import { ALL_RODS, bearing, bit, gainsText, PRESETS, RODS, markedText, whyUnseen } from "./rods";
import { TwinFaultsPanel } from "./TwinFaultsPanel";

const NUMBERS_PER_S = 4;

/** Ten switches along the drawn backbone, base left, tip right; under each what the observer misses there. */
export function SensingPanel() {
  const operations = useService(Operations);
  const mask = usePage((page) => page.settings?.sensed ?? 0);
  const twin = usePage((page) => page.rig?.twin ?? false);
  const gains = usePage(({ rig }) => (rig === null ? null : gainsText(mask, rig.parameters.controller)));
  const reason = useWhyNot("settings");
  const marked = usePage(({ rig }) => bearing(rig?.parameters.hardware?.motion_capture.rods));
  const choose = (sensed: (now: number) => number) => {
    if (reason !== null) return;
    void operations.changeSettings("Sensing not changed", (now) => ({ sensed: sensed(now.sensed) }));
  };
  return (
    <div className="panel">
      <Presets mask={mask} marked={marked} reason={reason} choose={choose} />
      <div className="backbone" role="group" aria-label="Sensed rods, base left, tip right">
        <span className="backbone-base">
          <span>base</span>
          <span className="backbone-row">residual</span>
          {twin ? <span className="backbone-row">estimate</span> : null}
        </span>
        {RODS.map((rod) => (
          <Sensor
            key={rod}
            rod={rod}
            mask={mask}
            marked={marked}
            reason={reason}
            choose={choose}
            twin={twin}
          />
        ))}
      </div>
      <p className="note">
        mm. Residual: from the measured marker to the observer
        {twin ? ". Estimate: from the observer to where the twin really is" : ""}
        {marked === ALL_RODS ? "" : `. ${markedText(marked)}`}
      </p>
      {gains === null ? null : <p className="note">{gains}</p>}
      {twin ? <TwinFaultsPanel /> : null}
    </div>
  );
}

interface ChoiceProps {
  readonly mask: number;
  /** Rods that bear a marker. */
  readonly marked: number;
  readonly reason: string | null;
  /** Change what is sensed now. */
  readonly choose: (sensed: (now: number) => number) => void;
}

function Presets({ mask, marked, reason: forbidden, choose }: ChoiceProps) {
  const presets = PRESETS.map((preset) => ({
    ...preset,
    reason: forbidden ?? whyUnseen(preset.sensed, marked),
  }));
  return (
    <div className="row" role="group" aria-label="Presets">
      {presets.map(({ label, testId, sensed, meaning, reason }) => (
        <Tooltip key={label} label={reason ?? meaning} openDelay={reason ? 0 : 500}>
          <button
            type="button"
            className="chip"
            aria-pressed={mask === sensed}
            aria-disabled={reason !== null}
            data-testid={testId}
            onClick={() => {
              if (reason === null) choose(() => sensed);
            }}
          >
            {label}
          </button>
        </Tooltip>
      ))}
    </div>
  );
}

interface SensorProps extends ChoiceProps {
  readonly rod: number;
  readonly twin: boolean;
}

function Sensor({ rod, mask, marked, reason: forbidden, choose, twin }: SensorProps) {
  const on = isSensed(mask, rod);
  const reason = forbidden ?? (on ? null : whyUnseen(bit(rod), marked));
  const live = useService(Live);
  const alive = usePage((page) => page.online && page.rigLive);
  const telemetry = () => (alive ? live.telemetry : null);
  const residual = () => {
    const now = telemetry();
    const marker = on && now && markersOf(now).find((seen) => seen.rod === rod);
    return marker ? millimetresOf(residualOf(marker)) : DASH;
  };
  const miss = () => {
    const now = telemetry();
    return now ? millimetresOf(missOf(now, rod)) : DASH;
  };
  return (
    <span className="sensor">
      <Tooltip
        label={reason ?? (on ? `Rod ${rod}: sensed` : `Rod ${rod}: not sensed`)}
        openDelay={reason ? 0 : 500}
      >
        <button
          type="button"
          className="sensor-dot"
          role="switch"
          aria-checked={on}
          aria-label={`Sense rod ${rod}`}
          aria-disabled={reason !== null}
          data-testid={`sense-${rod}`}
          onClick={() => {
            if (reason === null) choose((now) => now ^ bit(rod));
          }}
        >
          {rod}
        </button>
      </Tooltip>
      <LiveText read={residual} rate={NUMBERS_PER_S} testId={`residual-${rod}`} />
      {twin ? (
        <span className={on ? "sensor-twin" : "sensor-twin sensor-unsensed"}>
          <LiveText read={miss} rate={NUMBERS_PER_S} testId={`miss-${rod}`} />
        </span>
      ) : null}
    </span>
  );
}

function millimetresOf(distance: number): string {
  return plain(distance * 1e3, 1);
}
