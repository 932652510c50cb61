import { Table } from "@mantine/core";
import type { Metrics, Recording } from "../api/types";
import { useDashboard } from "../panels/context";
import { clock, DASH, degrees, localTime, millimetres, percent, plain, wholeNumber } from "../state/format";
import { RUN_STYLES } from "./quickCharts";
import { Sample } from "./QuickPlot";

const FIGURES: readonly (readonly [string, (metrics: Metrics) => string])[] = [
  ["RMSE", ({ rmse }) => millimetres(rmse, 2)],
  ["Largest", ({ max_error }) => millimetres(max_error, 2)],
  ["ISE", ({ ise }) => (ise === null ? DASH : `${plain(ise * 1e6, 2)} mm² s`)],
  ["Lag x", ({ lag_deg_x }) => degrees(lag_deg_x)],
  ["Lag y", ({ lag_deg_y }) => degrees(lag_deg_y)],
  ["Saturated", ({ saturated_share }) => percent(saturated_share, 1)],
  ["Residual", ({ residual_rms }) => millimetres(residual_rms, 2)],
  ["Unsensed rods", ({ unsensed_rms }) => millimetres(unsensed_rms, 2)],
  ["Feedback", ({ feedback_share }) => percent(feedback_share, 1)],
  ["Lost ticks", ({ lost }) => wholeNumber(lost)],
  ["On time", ({ on_time_share }) => percent(on_time_share)],
];

/** A row per recording, with the line that is its own in the plots. */
export function CompareTable({ recordings }: { readonly recordings: readonly Recording[] }) {
  const { page } = useDashboard();
  return (
    <div className="compare-table" tabIndex={0} role="region" aria-label="Figures of the recordings">
      <Table verticalSpacing={3} data-testid="compare-table">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Recording</Table.Th>
            <Table.Th>Time</Table.Th>
            <Table.Th className="right">Duration</Table.Th>
            {FIGURES.map(([title]) => (
              <Table.Th key={title} className="right">
                {title}
              </Table.Th>
            ))}
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {recordings.map(({ id, name, started, seconds, metrics }, i) => (
            <Table.Tr key={id}>
              <Table.Td>
                <Sample line={RUN_STYLES[i]} /> {i + 1}{" "}
                <button
                  type="button"
                  className="link"
                  onClick={() => {
                    page.patch({ reviewed: id, compared: [] });
                  }}
                >
                  {name || "unnamed"}
                </button>
              </Table.Td>
              <Table.Td className="number">{localTime(started)}</Table.Td>
              <Table.Td className="number right">{clock(seconds)}</Table.Td>
              {FIGURES.map(([title, show]) => (
                <Table.Td key={title} className="number right">
                  {metrics ? show(metrics) : DASH}
                </Table.Td>
              ))}
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </div>
  );
}
