import { Popover } from "@mantine/core";
import { IconChevronDown } from "@tabler/icons-react";
import { useMemo } from "react";
import { Live } from "../live/live";
import { PageStore, usePage } from "../live/page";
import type { TelemetryField } from "../live/telemetry";
import { wholeNumber } from "../ui/format";
import { useService } from "../ui/services";
import { useSampled } from "../ui/ticker";
import { GAUGES, gradeOf, meaningOf, Peak, worstOf, type Measure } from "./health";
import { HealthReading } from "./HealthReading";

interface Reading {
  readonly measure: Measure;
  readonly read: () => number;
  /** The number that is shown, where it is another one than the graded. */
  readonly shown?: () => number;
  readonly rate?: number;
  readonly testId: string;
  readonly also?: string;
}

/** Timing and trust in one mark and the worst number, always on screen; the rest on a press. */
export function Health() {
  const readings = useReadings();
  const alarms = usePage((page) => page.alarms);
  const viewers = usePage((page) => page.health?.viewers ?? NaN);
  const worst = useSampled(
    () => worstOf(readings.map(({ measure, read }) => gradeOf(measure, read(), alarms))),
    2,
  );
  const { measure, read, shown } = readings[worst];
  return (
    <Popover position="bottom-start" shadow="md">
      <Popover.Target>
        <button type="button" className="health-chip" data-testid="health" title={meaningOf(measure, alarms)}>
          <HealthReading measure={measure} read={read} shown={shown} />
          <span className="health-name">{GAUGES[measure].name}</span>
          <IconChevronDown size={14} aria-hidden />
        </button>
      </Popover.Target>
      <Popover.Dropdown>
        <dl className="health-list" aria-label="Health">
          {readings.map((one) => (
            <div key={one.testId} title={`${meaningOf(one.measure, alarms)}${one.also ?? ""}`}>
              <dt>{GAUGES[one.measure].name}</dt>
              <dd>
                <HealthReading {...one} />
              </dd>
            </div>
          ))}
          <div title="Pages that are open on this rig">
            <dt>viewers</dt>
            <dd className="number">{wholeNumber(viewers)}</dd>
          </div>
        </dl>
        <p className="note">More, with histogram and limits: the tab Health</p>
      </Popover.Dropdown>
    </Popover>
  );
}

function useReadings(): readonly Reading[] {
  const live = useService(Live);
  const alive = usePage((page) => page.online && page.rigLive);
  const policy = usePage((page) => page.rig?.policy ?? "");
  const measured = useMemo(() => new Peak(), []);
  const commanded = useMemo(() => new Peak(), []);
  const page = useService(PageStore);
  const ofMinute = (name: "on_time" | "lost") => (alive ? (page.get().health?.[name] ?? NaN) : NaN);
  const read = (name: TelemetryField) => (alive ? (live.telemetry?.at(name) ?? NaN) : NaN);
  return [
    {
      measure: "onTime",
      read: () => ofMinute("on_time"),
      testId: "on-time",
      also: ` Scheduling: ${policy || "unknown"}.`,
    },
    {
      measure: "lost",
      read: () => ofMinute("lost"),
      shown: () => read("lost"),
      testId: "lost",
      also: " The number is counted since the rig started.",
    },
    { measure: "step", read: () => 1e-9 * read("step_ns"), testId: "step" },
    { measure: "roundTrip", read: () => live.roundTrip.at(), testId: "round-trip" },
    {
      measure: "commandAge",
      read: () => commanded.take(read("server_age")),
      rate: 5,
      testId: "command-age",
    },
    {
      measure: "measurementAge",
      read: () => measured.take(read("measurement_age")),
      rate: 5,
      testId: "measurement-age",
    },
    { measure: "residual", read: () => read("residual"), testId: "residual" },
  ];
}
