import { Loader, Table, Tooltip } from "@mantine/core";
import { useEffect, useState } from "react";
import type { Measured, Metrics } from "../../api/types";
import { DASH, plain, textOf } from "../../ui/format";
import { recordings } from "../recordings";

interface State {
  readonly measured: Measured | null;
  readonly problem: string;
}

/** All figures of a recording, whole and of each cycle, taken again by the server. */
export function Figures({ id }: { readonly id: string }) {
  const [{ measured, problem }, setState] = useState<State>({ measured: null, problem: "" });
  useEffect(() => {
    let gone = false;
    recordings.metrics(id).then(
      (found) => {
        if (!gone) setState({ measured: found, problem: "" });
      },
      (error: unknown) => {
        if (!gone) setState({ measured: null, problem: textOf(error) });
      },
    );
    return () => {
      gone = true;
    };
  }, [id]);
  if (problem !== "") return <p className="panel advice" role="alert">No figures: {problem}</p>; // prettier-ignore
  if (!measured) return <Loader m="xl" data-testid="figures-loading" />;
  return <Shown measured={measured} />;
}

function Shown({ measured: { whole, cycles } }: { readonly measured: Measured }) {
  return (
    <div className="figures" tabIndex={0} role="region" aria-label="Figures of the recording">
      <Table stickyHeader verticalSpacing={3} data-testid="figures">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Part</Table.Th>
            <FigureHeads />
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          <Table.Tr className="figures-whole">
            <Table.Td>Whole</Table.Td>
            <FigureCells metrics={whole} />
          </Table.Tr>
          {cycles.map((cycle, i) => (
            <Table.Tr key={i}>
              <Table.Td className="number">Cycle {i + 1}</Table.Td>
              <FigureCells metrics={cycle} />
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
      <p className="panel note">
        {cycles.length > 0
          ? "Whole: all that was tracked, with the way to the beginning. A cycle is one period of the reference."
          : "Its reference does not repeat, so there are no cycles."}
      </p>
    </div>
  );
}

/** One figure of a recording: its title, its unit ("" without any), and its number in that unit. */
interface Figure {
  readonly title: string;
  readonly unit: string;
  readonly meaning: string;
  readonly show: (metrics: Metrics) => string;
}

const mm = (of: (metrics: Metrics) => number | null) => scaled(of, 1e3, 2);
const percent = (of: (metrics: Metrics) => number | null, digits: number) => scaled(of, 100, digits);
const degrees = (of: (metrics: Metrics) => number | null) => scaled(of, 1, 1);

/** Everything that is measured of a recording. */
const FIGURES: readonly Figure[] = [
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

/** Titles of all figures, each with its unit below. */
export function FigureHeads() {
  return FIGURES.map(({ title, unit, meaning }) => (
    <Table.Th key={title} className="right">
      <Tooltip label={meaning}>
        <span>
          {title} <span className="unit figure-unit">{unit}</span>
        </span>
      </Tooltip>
    </Table.Th>
  ));
}

/** The numbers below them; dashes before they were taken. */
export function FigureCells({ metrics }: { readonly metrics: Metrics | null }) {
  return FIGURES.map(({ title, show }) => (
    <Table.Td key={title} className="number right">
      {metrics ? show(metrics) : DASH}
    </Table.Td>
  ));
}
