import type { LoopHealth } from "../api/types";
import { microseconds } from "../ui/format";

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
export function HealthHistogram({ loop }: { readonly loop: LoopHealth | null }) {
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
