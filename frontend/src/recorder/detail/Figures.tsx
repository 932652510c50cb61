import { Loader, Table } from "@mantine/core";
import { useEffect, useState } from "react";
import type { Measured } from "../../api/types";
import { textOf } from "../../ui/format";
import { recordings } from "../recordings";
import { FigureCells, FigureHeads } from "./FigureHeads";

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
