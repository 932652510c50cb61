import { Table } from "@mantine/core";
import { IconArrowDown, IconArrowUp } from "@tabler/icons-react";
import { nextOrder, type Column, type Order } from "./listing";

const COLUMNS: readonly (readonly [Column, string])[] = [
  ["starred", "★"],
  ["name", "Name"],
  ["started", "Time"],
  ["actuator", "Actuator"],
  ["reference", "Reference"],
  ["seconds", "Duration"],
  ["gaps", "Gaps"],
  ["rmse", "RMSE"],
  ["on_time_share", "On time"],
  ["bytes", "Size"],
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
    <Table.Thead>
      <Table.Tr>
        <Table.Th>
          <span className="sr-only">Compare</span>
        </Table.Th>
        {COLUMNS.map(([column, title]) => (
          <Title key={column} column={column} title={title} order={order} onOrder={onOrder} />
        ))}
        <Table.Th>
          <span className="sr-only">Actions</span>
        </Table.Th>
      </Table.Tr>
    </Table.Thead>
  );
}

interface TitleProps extends Props {
  readonly column: Column;
  readonly title: string;
}

function Title({ column, title, order, onOrder }: TitleProps) {
  const chosen = order.column === column;
  const Arrow = order.falling ? IconArrowDown : IconArrowUp;
  return (
    <Table.Th
      className={NUMBERS.has(column) ? "right" : ""}
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
        {title}
        {chosen ? <Arrow size={12} aria-hidden /> : null}
      </button>
    </Table.Th>
  );
}
