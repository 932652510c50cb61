import { Table } from "@mantine/core";
import type { Recording } from "../../api/types";
import { PageStore } from "../../live/page";
import { clock, localTime } from "../../ui/format";
import { useService } from "../../ui/services";
import { FigureCells, FigureHeads } from "../detail/FigureHeads";
import { RUN_STYLES } from "../quick/quickCharts";
import { Sample } from "../quick/QuickPlot";

/** A row per recording, with the line that is its own in the plots. */
export function CompareTable({ recordings }: { readonly recordings: readonly Recording[] }) {
  const page = useService(PageStore);
  return (
    <div className="compare-table" tabIndex={0} role="region" aria-label="Figures of the recordings">
      <Table fz="xs" verticalSpacing={3} data-testid="compare-table">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Recording</Table.Th>
            <Table.Th className="compare-time">Time</Table.Th>
            <Table.Th className="right">Duration</Table.Th>
            <FigureHeads />
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {recordings.map(({ id, name, started, seconds, metrics }, i) => (
            <Table.Tr key={id}>
              <Table.Td>
                <Sample line={RUN_STYLES[i]} /> {i + 1}{" "}
                <button
                  type="button"
                  className="link cut"
                  title={name}
                  onClick={() => {
                    page.patch({ reviewed: id, compared: [] });
                  }}
                >
                  {name || "unnamed"}
                </button>
              </Table.Td>
              <Table.Td className="number compare-time">{localTime(started)}</Table.Td>
              <Table.Td className="number right">{clock(seconds)}</Table.Td>
              <FigureCells metrics={metrics} />
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </div>
  );
}
