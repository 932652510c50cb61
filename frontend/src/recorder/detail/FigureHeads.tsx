import { Table, Tooltip } from "@mantine/core";
import type { Metrics } from "../../api/types";
import { DASH } from "../../ui/format";
import { FIGURES } from "./figures";

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
