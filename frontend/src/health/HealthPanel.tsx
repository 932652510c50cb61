import { Tooltip } from "@mantine/core";
import { useEffect, useState } from "react";
import { api, dataOf } from "../api/rest";
import type { LoopHealth } from "../api/types";
import { Live } from "../live/live";
import { usePage } from "../live/page";
import type { TelemetryField } from "../live/telemetry";
import { DASH, microseconds, milliseconds, percent, plain, wholeNumber } from "../ui/format";
import { useService } from "../ui/services";
import { GAUGES, gradeOf, meaningOf, type Measure } from "./health";
import { HealthHistogram } from "./HealthHistogram";
import { HealthLimits } from "./HealthLimits";
import { GradeWord } from "./HealthReading";

const REFRESH_MS = 1000;
const POWERS = ["damping", "pressures", "observer", "constraints"] as const;

interface Line {
  readonly measure: Measure;
  readonly value: number;
  /** More of the same, in small print. */
  readonly also?: string;
}

type Read = (name: TelemetryField, index?: number) => number;

/** Everything that tells whether the rig can be trusted now: timing, ages, observer, pressure loops, energy. */
export function HealthPanel() {
  const live = useService(Live);
  const alive = usePage((page) => page.online && page.rigLive);
  const link = usePage((page) => page.health?.link_rtt ?? NaN);
  const held = usePage((page) => page.lease.held);
  const loop = useLoopHealth();
  const read: Read = (name, index = 0) => (alive ? (live.telemetry?.at(name, index) ?? NaN) : NaN);
  const lines: readonly Line[] = [
    { measure: "onTime", value: alive ? live.onTime.share() : NaN, also: lastSeconds(loop) },
    {
      measure: "lost",
      value: alive ? live.onTime.lost() : NaN,
      also: `${wholeNumber(read("lost"))} since the start`,
    },
    { measure: "lateness", value: loop?.lateness?.p99 ?? NaN, also: spread(loop?.lateness) },
    { measure: "step", value: loop?.step?.p99 ?? NaN, also: spread(loop?.step) },
    { measure: "roundTrip", value: live.roundTrip },
    { measure: "rigLink", value: alive ? link : NaN },
    { measure: "commandAge", value: read("server_age") },
    { measure: "presenceAge", value: held ? read("operator_age") : NaN, also: held ? "" : "no one operates" },
    { measure: "measurementAge", value: read("measurement_age") },
    { measure: "residual", value: read("residual") },
    { measure: "pressureLag", value: loop?.pressure?.filling ?? NaN, also: lag(loop) },
    { measure: "ledger", value: read("ledger"), also: `H = ${millijoules(read("energy"))}` },
  ];
  return (
    <div className="panel health-panel" data-testid="health-panel" tabIndex={0}>
      <table className="gauges">
        <caption className="sr-only">Health of loop, observer and pressure loops</caption>
        <tbody>
          {lines.map((line) => (
            <Row key={line.measure} {...line} />
          ))}
        </tbody>
      </table>
      <section aria-label="Lateness of the loop">
        <HealthHistogram loop={loop} />
        <Powers read={read} />
        <HealthLimits />
      </section>
    </div>
  );
}

function Row({ measure, value, also = "" }: Line) {
  const alarms = usePage((page) => page.alarms);
  return (
    <Tooltip label={meaningOf(measure, alarms)} multiline maw={360} position="top-start">
      <tr data-testid={`gauge-${measure}`}>
        <th scope="row">{GAUGES[measure].name}</th>
        <td className="number">{GAUGES[measure].show(value)}</td>
        <td>
          <GradeWord grade={gradeOf(measure, value, alarms)} />
        </td>
        <td className="note number">{also}</td>
      </tr>
    </Tooltip>
  );
}

/** The four powers that feed and drain the stored energy; the last is Baumgarte's, which holds the hinges together. */
function Powers({ read }: { readonly read: Read }) {
  return (
    <dl className="facts powers">
      {POWERS.map((name, i) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd className="number">{milliwatts(read("power", i))}</dd>
        </div>
      ))}
    </dl>
  );
}

function spread(seconds: LoopHealth["step"] | undefined): string {
  if (!seconds) return "";
  return `p50 ${microseconds(1e9 * seconds.median)}, most ${microseconds(1e9 * seconds.largest)}`;
}

function lastSeconds(loop: LoopHealth | null): string {
  if (!loop || loop.ticks === 0) return "";
  return `${percent(loop.ticks / (loop.ticks + loop.lost))} of the last 10 s`;
}

function lag(loop: LoopHealth | null): string {
  if (!loop?.pressure) return "pressures rest";
  const { dead_time, exhausting, explained } = loop.pressure;
  const numbers = [dead_time, exhausting].map((time) => milliseconds(time, 0));
  return `d ${numbers[0]}, exhausting ${numbers[1]}, fit ${percent(explained, 0)}`;
}

function millijoules(energy: number): string {
  const text = plain(energy * 1e3, 2);
  return text === DASH ? text : `${text} mJ`;
}

function milliwatts(power: number): string {
  const text = plain(power * 1e3, 2);
  return text === DASH ? text : `${text} mW`;
}

/** The server's judgement of the loop, asked for once a second while it is shown; null while it does not answer. */
function useLoopHealth(): LoopHealth | null {
  const [health, setHealth] = useState<LoopHealth | null>(null);
  useEffect(() => {
    let shown = true;
    const ask = async () => {
      const answer = await dataOf(api.GET("/api/health/loop")).catch(() => null);
      if (shown) setHealth(answer);
    };
    const timer = setInterval(() => void ask(), REFRESH_MS);
    void ask();
    return () => {
      shown = false;
      clearInterval(timer);
    };
  }, []);
  return health;
}
