import { Tooltip } from "@mantine/core";
import { isSensed, markersOf, residualOf } from "../plan/residual";
import { DASH } from "../state/format";
import { LiveText } from "./LiveText";
import { useDashboard, usePage, useWhyNot } from "./context";

const RODS = Array.from({ length: 10 }, (_, i) => i + 1);
const bit = (rod: number) => 1 << (rod - 1);

const PRESETS: readonly (readonly [string, number])[] = [
  ["Tip", bit(10)],
  ["Rod 6", bit(6)],
  ["6 + 10", bit(6) | bit(10)],
  ["None", 0],
];

/** Ten switches along the drawn backbone, base left, tip right; the residual in mm under each marker that is seen. */
export function SensingPanel() {
  const dashboard = useDashboard();
  const mask = usePage((page) => page.settings?.sensed ?? 0);
  const reason = useWhyNot("settings");
  const choose = (sensed: number) => {
    if (reason === null) void dashboard.operations.changeSettings("Sensing not changed", { sensed });
  };
  return (
    <div className="panel">
      <div className="row" role="group" aria-label="Presets">
        {PRESETS.map(([label, preset]) => (
          <Tooltip key={label} label={reason ?? `Sense ${label.toLowerCase()}`} openDelay={reason ? 0 : 500}>
            <button
              type="button"
              className="chip"
              aria-pressed={mask === preset}
              aria-disabled={reason !== null}
              data-testid={`preset-${label.toLowerCase().replaceAll(" ", "")}`}
              onClick={() => {
                choose(preset);
              }}
            >
              {label}
            </button>
          </Tooltip>
        ))}
        <span className="note">The observer uses the filled markers.</span>
      </div>
      <div className="backbone" role="group" aria-label="Sensed rods, base left, tip right">
        <span className="backbone-base">base</span>
        {RODS.map((rod) => (
          <Sensor key={rod} rod={rod} mask={mask} reason={reason} choose={choose} />
        ))}
      </div>
      <p className="note">
        Residual |measured − observer| in mm under each rod; a dash where its marker is not seen.
      </p>
    </div>
  );
}

interface SensorProps {
  readonly rod: number;
  readonly mask: number;
  readonly reason: string | null;
  readonly choose: (mask: number) => void;
}

function Sensor({ rod, mask, reason, choose }: SensorProps) {
  const on = isSensed(mask, rod);
  const { live } = useDashboard();
  const read = () => {
    const marker = live.telemetry && markersOf(live.telemetry).find((seen) => seen.rod === rod);
    const residual = marker ? residualOf(marker) : NaN;
    return Number.isFinite(residual) ? (residual * 1e3).toFixed(1) : DASH;
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
            choose(mask ^ bit(rod));
          }}
        >
          {rod}
        </button>
      </Tooltip>
      <LiveText read={read} rate={4} />
    </span>
  );
}
