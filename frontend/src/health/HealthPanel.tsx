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
  const onTime = usePage((page) => page.health?.on_time ?? NaN);
  const lost = usePage((page) => page.health?.lost ?? NaN);
  const balance = usePage((page) => page.health?.energy_balance ?? NaN);
  const held = usePage((page) => page.lease.held);
  const loop = useLoopHealth();
  const read: Read = (name, index = 0) => (alive ? (live.telemetry?.at(name, index) ?? NaN) : NaN);
  const lines: readonly Line[] = [
    { measure: "onTime", value: alive ? onTime : NaN, also: lastSeconds(loop) },
    {
      measure: "lost",
      value: alive ? lost : NaN,
      also: `${wholeNumber(read("lost"))} since the start`,
    },
    { measure: "lateness", value: loop?.lateness?.p99 ?? NaN, also: spread(loop?.lateness) },
    { measure: "step", value: loop?.step?.p99 ?? NaN, also: spread(loop?.step) },
    { measure: "roundTrip", value: live.roundTrip.at() },
    { measure: "rigLink", value: alive ? link : NaN },
    { measure: "commandAge", value: read("server_age") },
    { measure: "presenceAge", value: held ? read("operator_age") : NaN, also: held ? "" : "no one operates" },
    { measure: "measurementAge", value: read("measurement_age") },
    { measure: "residual", value: read("residual") },
    { measure: "pressureLag", value: loop?.pressure?.filling ?? NaN, also: lag(loop) },
    { measure: "ledger", value: alive ? balance : NaN, also: `H = ${millijoules(read("energy"))}` },
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

const WIDTH = 260;
const HEIGHT = 92;
const FLOOR = 76;
const LEFT = 4;
const LATENESS_MIN_S = 1e-6;
const LATENESS_MAX_S = 1e-1;
const TICK_S = 1e-3;
const MARKS = [
  [1e-6, "1 µs"],
  [1e-5, "10 µs"],
  [1e-4, "100 µs"],
  [1e-3, "1 ms"],
  [1e-2, "10 ms"],
] as const;

/** Place of a lateness [s] on the logarithmic axis. */
function across(lateness: number): number {
  const share =
    Math.log10(Math.max(lateness, LATENESS_MIN_S) / LATENESS_MIN_S) /
    Math.log10(LATENESS_MAX_S / LATENESS_MIN_S);
  return LEFT + Math.min(1, share) * (WIDTH - 2 * LEFT);
}

/** How late the ticks of the last 10 s woke up; heights are logarithmic too, so that a single late tick shows. */
function HealthHistogram({ loop }: { readonly loop: LoopHealth | null }) {
  const lateness = loop?.lateness ?? null;
  const words = lateness
    ? `p50 ${microseconds(1e9 * lateness.median)}, p99 ${microseconds(1e9 * lateness.p99)}`
    : "no ticks yet";
  return (
    <figure className="histogram">
      <figcaption>
        lateness of {loop?.ticks ?? 0} ticks <span className="number">{words}</span>
      </figcaption>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={`Histogram of lateness: ${words}`}>
        {loop ? <Bars loop={loop} /> : null}
        {lateness ? <Quantile at={lateness.median} name="p50" anchor="end" /> : null}
        {lateness ? <Quantile at={lateness.p99} name="p99" anchor="start" /> : null}
        <line className="axis" x1={LEFT} x2={WIDTH - LEFT} y1={FLOOR} y2={FLOOR} />
        {MARKS.map(([at, label]) => (
          <text
            key={label}
            x={across(at)}
            y={HEIGHT - 3}
            textAnchor={at === LATENESS_MIN_S ? "start" : "middle"}
          >
            {label}
          </text>
        ))}
      </svg>
    </figure>
  );
}

function Bars({ loop }: { readonly loop: LoopHealth }) {
  const top = Math.log10(1 + Math.max(1, loop.ticks));
  return loop.counts.map((count, i) => {
    const [from, to] = [across(loop.edges[i]), across(loop.edges[i + 1])];
    const height = ((FLOOR - 14) * Math.log10(1 + count)) / top;
    return (
      <rect
        key={loop.edges[i]}
        className={loop.edges[i] >= TICK_S * 0.99 ? "bar-late" : "bar-timely"}
        x={from}
        width={Math.max(1.5, to - from - 0.8)}
        y={FLOOR - height}
        height={height}
      />
    );
  });
}

interface QuantileProps {
  readonly at: number;
  readonly name: string;
  /** The side on which the name stands: two quantiles may be close. */
  readonly anchor: "start" | "end";
}

function Quantile({ at, name, anchor }: QuantileProps) {
  const x = across(at);
  return (
    <>
      <line className="quantile" x1={x} x2={x} y1={11} y2={FLOOR} />
      <text x={x} y={9} textAnchor={anchor}>
        {name}
      </text>
    </>
  );
}
