import { Loader, SegmentedControl, Table } from "@mantine/core";
import { useMemo, useState } from "react";
import type { Recording } from "../../api/types";
import { Back, Unknown } from "../detail/Detail";
import { comparedPaths } from "../quick/paths";
import { comparedCharts, RUN_STYLES, type Common, type Compared } from "../quick/quickCharts";
import { PlotsAndPath } from "../quick/QuickLook";
import { useQuick } from "../quick/useQuick";
import type { Recordings } from "../useRecordings";
import { PageStore } from "../../live/page";
import { clock, localTime } from "../../ui/format";
import { useService } from "../../ui/services";
import { FigureCells, FigureHeads } from "../detail/Figures";
import { Sample } from "../quick/QuickPlot";

interface Props {
  readonly ids: readonly string[];
  readonly recordings: Recordings;
  readonly onBack: () => void;
}

/** Up to four runs, each from its start or by phase, their paths together, their figures in a table. */
export function Compare({ ids, recordings, onBack }: Props) {
  const found = ids.map(recordings.find);
  const unknown = found.findIndex((row) => !row);
  if (unknown >= 0) return <Unknown id={ids[unknown]} onBack={onBack} />;
  return <Known recordings={found.filter((row) => row !== null && row !== undefined)} onBack={onBack} />;
}

interface KnownProps {
  readonly recordings: readonly Recording[];
  readonly onBack: () => void;
}

function Known({ recordings, onBack }: KnownProps) {
  const { looks, problem } = useQuick(recordings.map(({ id }) => id), false); // prettier-ignore
  const [wish, setWish] = useState<Common>("time");
  const runs = useMemo(() => looks?.map((quick): Compared => ({ quick })) ?? [], [looks]);
  const periodic = runs.length > 0 && runs.every(({ quick }) => quick.period !== null);
  const common = periodic ? wish : "time";
  const charts = useMemo(() => comparedCharts(runs, common), [runs, common]);
  const paths = useMemo(() => comparedPaths(runs), [runs]);
  return (
    <main className="review" data-testid="comparison">
      <div className="bar review-bar">
        <Back onBack={onBack} />
        <h2 className="bar-title" tabIndex={-1} data-focus-home>
          {recordings.length} recordings compared
        </h2>
        <span className="spacer" />
        <span className="note">
          {common === "time"
            ? "Each from the start of its run; approaches and pauses are left out."
            : "The median of all laps."}
          {periodic ? "" : " Phase needs a periodic reference in each."}
        </span>
        <SegmentedControl
          size="xs"
          aria-label="Common axis"
          data-testid="common-axis"
          disabled={!periodic}
          value={common}
          onChange={setWish}
          data={[
            { value: "time", label: "Time" },
            { value: "phase", label: "Phase" },
          ]}
        />
      </div>
      <CompareTable recordings={recordings} />
      {
        problem === "" ? null : <p className="panel advice" role="alert">No comparison: {problem}</p> /* prettier-ignore */
      }
      {looks === null && problem === "" ? <Loader m="xl" /> : null}
      {runs.length === 0 ? null : (
        <PlotsAndPath
          key={common}
          charts={charts}
          paths={paths}
          group={`compare-${common}`}
          unitX={common === "time" ? "s" : "cycle"}
        />
      )}
    </main>
  );
}

/** A row per recording, with the line that is its own in the plots. */
function CompareTable({ recordings }: { readonly recordings: readonly Recording[] }) {
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
                  onClick={() => page.patch({ reviewed: id, compared: [] })}
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
