import { IconArrowDown, IconArrowUp } from "@tabler/icons-react";
import { nextOrder, type Column, type Order } from "./listing";

/** Columns, titles and units; the classes say where a narrow page leaves one out. */
const COLUMNS: readonly (readonly [Column, string, string])[] = [
  ["starred", "★", ""],
  ["name", "Name", ""],
  ["started", "When", ""],
  ["actuator", "Actuator", ""],
  ["reference", "Reference", ""],
  ["seconds", "Duration", "min:s"],
  ["gaps", "Gaps", "ticks"],
  ["rmse", "RMSE", "mm"],
  ["on_time_share", "On time", "%"],
  ["bytes", "Size", "MB"],
];
const NUMBERS = new Set<Column>(["seconds", "rmse", "on_time_share", "gaps", "bytes"]);
const SPOKEN: Partial<Record<Column, string>> = { starred: "Star" };

interface Props {
  readonly order: Order;
  readonly onOrder: (order: Order) => void;
}

/** Titles of the list's columns: a click sorts, another one turns the order round. */
export function Titles({ order, onOrder }: Props) {
  return (
    <thead>
      <tr>
        <th className="list-tick">
          <span className="sr-only">Compare</span>
        </th>
        <th className="list-path">
          <span className="sr-only">Path</span>
        </th>
        {COLUMNS.map(([column, title, unit]) => (
          <Title key={column} column={column} title={title} unit={unit} order={order} onOrder={onOrder} />
        ))}
        <th className="list-actions">
          <span className="sr-only">Actions</span>
        </th>
      </tr>
    </thead>
  );
}

interface TitleProps extends Props {
  readonly column: Column;
  readonly title: string;
  readonly unit: string;
}

function Title({ column, title, unit, order, onOrder }: TitleProps) {
  const chosen = order.column === column;
  const Arrow = order.falling ? IconArrowDown : IconArrowUp;
  return (
    <th
      className={`list-${column}${NUMBERS.has(column) ? " right" : ""}`}
      aria-sort={chosen ? (order.falling ? "descending" : "ascending") : "none"}
    >
      <button
        type="button"
        className="link"
        aria-label={SPOKEN[column]}
        data-testid={`sort-${column}`}
        onClick={() => {
          onOrder(nextOrder(order, column));
        }}
      >
        {title} {unit === "" ? null : <span className="unit">{unit}</span>}
        {chosen ? <Arrow size={12} aria-hidden /> : null}
      </button>
    </th>
  );
}
