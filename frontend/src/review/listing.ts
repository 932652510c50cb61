import type { Recording } from "../api/types";

export type Column =
  "starred" | "name" | "started" | "actuator" | "seconds" | "rmse" | "on_time_share" | "gaps" | "bytes";

export interface Order {
  readonly column: Column;
  readonly falling: boolean;
}

export const NEWEST: Order = { column: "started", falling: true };

/** The recordings that have every word of `query` somewhere, in `order`; what has no value comes last either way. */
export function listed(rows: readonly Recording[], query: string, { column, falling }: Order): Recording[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const sign = falling ? -1 : 1;
  return rows
    .filter((row) => {
      const text = textOf(row);
      return words.every((word) => text.includes(word));
    })
    .sort((a, b) => compared(valueOf(a, column), valueOf(b, column), sign) || compared(a.id, b.id, -1));
}

/** A click on a title: fall first where large is interesting, turn round at the second. */
export function nextOrder(order: Order, column: Column): Order {
  if (order.column === column) return { column, falling: !order.falling };
  return { column, falling: column !== "name" && column !== "actuator" };
}

/** What is remarkable about a recording, in words. */
export function badgesOf(row: Recording, running: boolean): string[] {
  return [
    ...(running ? ["recording now"] : []),
    ...(row.recovered ? ["recovered"] : []),
    ...(!running && !row.complete && !row.recovered ? ["cut short"] : []),
    ...(row.gaps > 0 ? [`${row.gaps} ticks missing`] : []),
    ...(row.restarts.length > 0 ? ["rig restarted"] : []),
    ...(row.imported ? ["imported"] : []),
    ...(row.part_of === "" ? [] : ["part"]),
  ];
}

type Value = string | number | null;

function valueOf(row: Recording, column: Column): Value {
  switch (column) {
    case "rmse":
    case "on_time_share":
      return row.metrics?.[column] ?? null;
    case "starred":
      return Number(row.starred);
    case "name":
    case "actuator":
      return row[column].toLowerCase();
    case "started":
      return Date.parse(row.started);
    case "seconds":
    case "gaps":
    case "bytes":
      return row[column];
  }
}

function compared(a: Value, b: Value, sign: number): number {
  if (a === b) return 0;
  if (a === null) return 1;
  if (b === null) return -1;
  return a < b ? -sign : sign;
}

function textOf(row: Recording): string {
  const { id, name, actuator, operator, reference, notes, tags } = row;
  return [id, name, actuator, operator, reference, notes, ...tags].join("\n").toLowerCase();
}
