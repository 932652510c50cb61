import { NativeSelect } from "@mantine/core";
import type { ImportChoices, ImportProposal, ProposedColumn, ProposedRow } from "../../api/types";
import { plain } from "../../ui/format";
import { assigned, LENGTHS, TIMES, type LengthUnit, type Meaning, type TimeUnit } from "./proposal";

interface Props {
  readonly proposal: ImportProposal;
  readonly onChoose: (choices: ImportChoices) => void;
}

/** Columns and first rows of the file, each with what it is taken as; what the file does not say is chosen here. */
export function ColumnTable({ proposal, onChoose }: Props) {
  const { columns, rows } = proposal;
  return (
    <div className="import-columns">
      <table data-testid="import-columns">
        <thead>
          <tr>
            <th scope="col">line</th>
            {columns.map((column, i) => (
              <th scope="col" key={i}>
                <span className="import-title">{proposal.header ? column.title : `column ${i + 1}`}</span>
                <NativeSelect
                  size="xs"
                  aria-label={`Column ${i + 1} is`}
                  data-testid={`import-column-${i + 1}`}
                  value={column.name ?? ""}
                  data={[{ value: "", label: "not used" }, "x", "y", "t"]}
                  onChange={(event) => onChoose(assigned(columns, i, meaningOf(event.currentTarget.value)))}
                />
                <Unit column={column} onChoose={onChoose} />
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr key={row.line}>
              <td className="note number">{row.line}</td>
              {row.cells.map((cell, i) => (
                <td key={i} className="number">
                  {cell === "" ? <em>empty</em> : cell}
                  <span className="note">{readAs(columns.at(i), row)}</span>
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** The unit that the file says; where it says none, a choice. */
function Unit({
  column,
  onChoose,
}: {
  readonly column: ProposedColumn;
  readonly onChoose: Props["onChoose"];
}) {
  if (column.name === null) return null;
  if (column.stated) return <span className="import-stated">in {shown(column.unit ?? "")}</span>;
  const time = column.name === "t";
  return (
    <NativeSelect
      size="xs"
      aria-label={`Unit of ${column.name}`}
      data-testid={`import-unit-${column.name}`}
      error={column.unit === null}
      value={column.unit ?? ""}
      data={[
        ...(column.unit === null ? [{ value: "", label: "unit?" }] : []),
        ...(time ? TIMES : LENGTHS).map((unit) => ({ value: unit, label: shown(unit) })),
      ]}
      onChange={(event) => {
        const unit = event.currentTarget.value;
        if (time) onChoose({ time_unit: unit as TimeUnit });
        else onChoose({ length_unit: unit as LengthUnit });
      }}
    />
  );
}

/** What the cell of `column` is in `row`, as soon as its unit is known. */
function readAs(column: ProposedColumn | undefined, { t, point }: ProposedRow): string {
  if (!column || column.unit === null || point === null) return "";
  switch (column.name) {
    case "t":
      return `${plain(t, 3)} s`;
    case "x":
      return `${plain(point[0] * 1e3, 2)} mm`;
    case "y":
      return `${plain(point[1] * 1e3, 2)} mm`;
    case null:
      return "";
  }
}

function meaningOf(value: string): Meaning | null {
  return value === "t" || value === "x" || value === "y" ? value : null;
}

function shown(unit: string): string {
  return unit.replace(/^u/, "µ");
}
