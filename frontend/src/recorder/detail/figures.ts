import type { Metrics } from "../../api/types";
import { DASH, plain } from "../../ui/format";

/** One figure of a recording: its title, its unit ("" without any), and its number in that unit. */
export interface Figure {
  readonly title: string;
  readonly unit: string;
  readonly meaning: string;
  readonly show: (metrics: Metrics) => string;
}

const mm = (of: (metrics: Metrics) => number | null) => scaled(of, 1e3, 2);
const percent = (of: (metrics: Metrics) => number | null, digits: number) => scaled(of, 100, digits);
const degrees = (of: (metrics: Metrics) => number | null) => scaled(of, 1, 1);

/** Everything that is measured of a recording. */
export const FIGURES: readonly Figure[] = [
  { title: "RMSE", unit: "mm", meaning: "Root mean square of the error", show: mm(({ rmse }) => rmse) },
  { title: "Max error", unit: "mm", meaning: "Largest error", show: mm(({ max_error }) => max_error) },
  { title: "SSE", unit: "mm", meaning: "Mean error over the last tenth", show: mm(({ sse }) => sse) },
  {
    title: "ISE",
    unit: "mm² s",
    meaning: "Squared error summed over time",
    show: ({ ise }) => three(ise, 1e6),
  },
  {
    title: "Lag x",
    unit: "°",
    meaning: "Phase behind the reference",
    show: degrees(({ lag_deg_x }) => lag_deg_x),
  },
  {
    title: "Lag y",
    unit: "°",
    meaning: "Phase behind the reference",
    show: degrees(({ lag_deg_y }) => lag_deg_y),
  },
  {
    title: "Saturated",
    unit: "%",
    meaning: "Share of the ticks whose command was clamped",
    show: percent(({ saturated_share }) => saturated_share, 1),
  },
  {
    title: "Residual",
    unit: "mm",
    meaning: "RMS distance of the observer from what was measured",
    show: mm(({ residual_rms }) => residual_rms),
  },
  {
    title: "Unsensed",
    unit: "mm",
    meaning: "RMS distance of the observer from the twin at rods that were not sensed",
    show: mm(({ unsensed_rms }) => unsensed_rms),
  },
  {
    title: "Feedback",
    unit: "%",
    meaning: "Share of the feedback in the command",
    show: percent(({ feedback_share }) => feedback_share, 1),
  },
  {
    title: "Lost",
    unit: "ticks",
    meaning: "Slots of the time grid without a tick",
    show: ({ lost }) => plain(lost, 0),
  },
  {
    title: "On time",
    unit: "%",
    meaning: "Share of the slots that had their tick",
    show: percent(({ on_time_share }) => on_time_share, 2),
  },
];

function scaled(of: (metrics: Metrics) => number | null, scale: number, digits: number) {
  return (metrics: Metrics) => {
    const value = of(metrics);
    return plain(value === null ? null : value * scale, digits);
  };
}

/** Three digits that count, for what ranges over decades. */
function three(value: number | null, scale: number): string {
  if (value === null) return DASH;
  const scaledValue = value * scale;
  const size = Math.floor(Math.log10(Math.abs(scaledValue) || 1));
  return plain(scaledValue, Math.min(6, Math.max(0, 2 - size)));
}
