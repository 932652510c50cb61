import { Tooltip } from "@mantine/core";
import { useRef, type ReactNode } from "react";
import { DASH, microseconds, millimetres, milliseconds, percent, wholeNumber } from "../state/format";
import type { TelemetryField } from "../state/telemetry";
import { LiveText } from "./LiveText";
import { useDashboard, usePage } from "./context";

interface ItemProps {
  readonly name: string;
  readonly meaning: string;
  readonly children: ReactNode;
}

function Item({ name, meaning, children }: ItemProps) {
  return (
    <Tooltip label={meaning} multiline maw={320}>
      <span className="health-item">
        <span className="health-name">{name}</span> {children}
      </span>
    </Tooltip>
  );
}

/** Timing and trust in numbers, always on screen. */
export function HealthStrip() {
  const { live } = useDashboard();
  const alive = usePage((page) => page.online && page.rigLive);
  const policy = usePage((page) => page.rig?.policy ?? "");
  const link = usePage((page) => page.health?.link_rtt ?? NaN);
  const viewers = usePage((page) => page.health?.viewers ?? NaN);
  const worst = useRef(NaN);
  const read = (name: TelemetryField) => (alive ? live.telemetry?.at(name) : NaN);
  return (
    <div className="health" data-testid="health" aria-label="Health">
      <Item
        name="on time"
        meaning={`Share of 1 kHz slots in which the loop ticked, last minute. Scheduling: ${policy || "unknown"}`}
      >
        <LiveText read={() => (alive ? percent(live.onTime.share()) : DASH)} rate={2} testId="on-time" />
      </Item>
      <Item name="lost" meaning="Ticks lost since the rig started">
        <LiveText read={() => wholeNumber(read("lost"))} testId="lost" />
      </Item>
      <Item name="step" meaning="Duration of one controller tick, plant excluded">
        <LiveText read={() => microseconds(read("step_ns"))} rate={4} testId="step" />
      </Item>
      <Item
        name="round trip"
        meaning={`Page to server and back. Server to the rig's loop and back: ${milliseconds(link)}`}
      >
        <LiveText read={() => milliseconds(live.roundTrip)} rate={2} testId="round-trip" />
      </Item>
      <Item
        name="measurement"
        meaning="Age of the newest marker measurement; the largest of the last moments"
      >
        <LiveText
          read={() => milliseconds(peak(worst, read("measurement_age") ?? NaN), 0)}
          testId="measurement-age"
        />
      </Item>
      <Item name="residual" meaning="Measured minus observer, RMS over the sensed rods">
        <LiveText read={() => millimetres(read("residual"), 2)} rate={4} testId="residual" />
      </Item>
      <Item name="viewers" meaning="Pages that are open on this rig">
        <span className="number">{wholeNumber(viewers)}</span>
      </Item>
      <Flags />
    </div>
  );
}

/** The larger of the value and a slowly forgotten maximum: an age that saws between 0 and 10 ms reads as 10. */
function peak(held: { current: number }, value: number): number {
  const before = Number.isFinite(held.current) ? held.current : value;
  held.current = Number.isFinite(value) ? Math.max(value, 0.7 * before) : NaN;
  return held.current;
}

function Flags() {
  const saturated = usePage((page) => page.rigLive && page.saturated);
  const unreachable = usePage((page) => page.rigLive && !page.reachable);
  return (
    <span className="flags">
      <Tooltip label="The command is at its limit; the integral is held">
        <span className={saturated ? "flag flag-on" : "flag"} aria-hidden={!saturated}>
          saturated
        </span>
      </Tooltip>
      <Tooltip label="The target is out of reach: the reference is the nearest point that can be reached">
        <span
          className={unreachable ? "flag flag-on" : "flag"}
          aria-hidden={!unreachable}
          data-testid="unreachable"
        >
          out of reach
        </span>
      </Tooltip>
    </span>
  );
}
