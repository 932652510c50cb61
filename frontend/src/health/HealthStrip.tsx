import { Tooltip } from "@mantine/core";
import { useMemo, type ReactNode } from "react";
import { Live } from "../live/live";
import { usePage } from "../live/page";
import type { TelemetryField } from "../rig/telemetry";
import { wholeNumber } from "../ui/format";
import { Painters } from "../ui/painters";
import { useService } from "../ui/services";
import { useStore } from "../ui/store";
import { meaningOf, Peak, type Measure } from "./health";
import { HealthReading } from "./HealthReading";

interface ItemProps {
  readonly name: string;
  readonly meaning: string;
  readonly minor?: boolean;
  readonly children: ReactNode;
}

function Item({ name, meaning, minor = false, children }: ItemProps) {
  return (
    <Tooltip label={meaning} multiline maw={340}>
      <span className={minor ? "health-item health-minor" : "health-item"}>
        <span className="health-name">{name}</span> {children}
      </span>
    </Tooltip>
  );
}

interface GaugeProps {
  readonly name: string;
  readonly measure: Measure;
  readonly read: () => number;
  readonly shown?: () => number;
  readonly rate?: number;
  readonly testId: string;
  readonly minor?: boolean;
  readonly also?: string;
}

function Gauge({ name, measure, also = "", minor = false, ...reading }: GaugeProps) {
  const alarms = usePage((page) => page.alarms);
  return (
    <Item name={name} meaning={`${meaningOf(measure, alarms)}${also}`} minor={minor}>
      <HealthReading measure={measure} {...reading} />
    </Item>
  );
}

/** Timing and trust in numbers, always on screen. */
export function HealthStrip() {
  const live = useService(Live);
  const alive = usePage((page) => page.online && page.rigLive);
  const policy = usePage((page) => page.rig?.policy ?? "");
  const viewers = usePage((page) => page.health?.viewers ?? NaN);
  const measured = useMemo(() => new Peak(), []);
  const commanded = useMemo(() => new Peak(), []);
  const read = (name: TelemetryField) => (alive ? (live.telemetry?.at(name) ?? NaN) : NaN);
  return (
    <section className="health" data-testid="health" aria-label="Health">
      <Gauge
        name="on time"
        measure="onTime"
        read={() => (alive ? live.onTime.share() : NaN)}
        testId="on-time"
        also={` Scheduling: ${policy || "unknown"}.`}
      />
      <Gauge
        name="lost"
        measure="lost"
        read={() => (alive ? live.onTime.lost() : NaN)}
        shown={() => read("lost")}
        testId="lost"
        also=" The number is counted since the rig started."
      />
      <Gauge name="step" measure="step" read={() => 1e-9 * read("step_ns")} testId="step" />
      <Gauge name="round trip" measure="roundTrip" read={() => live.roundTrip} testId="round-trip" />
      <Gauge
        name="command"
        measure="commandAge"
        read={() => commanded.take(read("server_age"))}
        rate={5}
        testId="command-age"
      />
      <Gauge
        name="measurement"
        measure="measurementAge"
        read={() => measured.take(read("measurement_age"))}
        rate={5}
        testId="measurement-age"
      />
      <Gauge name="residual" measure="residual" read={() => read("residual")} testId="residual" />
      <Item name="viewers" meaning="Pages that are open on this rig" minor>
        <span className="number">{wholeNumber(viewers)}</span>
      </Item>
      <Flags />
    </section>
  );
}

/** What failed to draw: the rest goes on, and it is tried again. */
function NotDrawn() {
  const painters = useService(Painters);
  const names = useStore(painters.failed, (failed) => failed.names);
  if (names.length === 0) return null;
  return (
    <Tooltip label={`Not drawn, and tried again: ${names.join(", ")}. The log says why.`} multiline maw={340}>
      <span className="flag flag-on flag-bad" role="alert" data-testid="not-drawn">
        not drawn: {names[0]}
        {names.length > 1 ? ` and ${names.length - 1} more` : ""}
      </span>
    </Tooltip>
  );
}

function Flags() {
  const saturated = usePage((page) => page.rigLive && page.saturated);
  const unreachable = usePage((page) => page.rigLive && !page.reachable);
  return (
    <span className="flags">
      <NotDrawn />
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
