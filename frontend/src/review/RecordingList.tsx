import { ActionIcon, Button, Pagination, Table, TextInput, Tooltip } from "@mantine/core";
import { IconArrowDown, IconArrowUp, IconRefresh } from "@tabler/icons-react";
import { useDeferredValue } from "react";
import type { Recording } from "../api/types";
import { useDashboard } from "../panels/context";
import { listed, nextOrder, type Column, type Order } from "./listing";
import { COMPARED_MAX } from "./place";
import { RecordingRow } from "./RecordingRow";
import { useActive, type Recordings } from "./useRecordings";

const SHELF = 100;
const COLUMNS: readonly (readonly [Column, string])[] = [
  ["starred", "★"],
  ["name", "Name"],
  ["started", "Time"],
  ["actuator", "Actuator"],
  ["seconds", "Duration"],
  ["gaps", "Gaps"],
  ["rmse", "RMSE"],
  ["on_time_share", "On time"],
  ["bytes", "Size"],
];
const NUMBERS = new Set<Column>(["seconds", "rmse", "on_time_share", "gaps", "bytes"]);
const SPOKEN: Partial<Record<Column, string>> = { starred: "Star" };

export interface Search {
  readonly query: string;
  readonly order: Order;
  /** Which hundred of the rows found, from 1 on. */
  readonly shelf: number;
}

interface Props {
  readonly recordings: Recordings;
  readonly rows: readonly Recording[];
  readonly search: Search;
  readonly onSearch: (change: Partial<Search>) => void;
  readonly ticked: readonly string[];
  readonly onTick: (ids: readonly string[]) => void;
}

/** The list with search, sorting and ticks; a hundred rows at a time, so that thousands stay fluid. */
export function RecordingList({ recordings, rows, search, onSearch, ticked, onTick }: Props) {
  const { page } = useDashboard();
  const active = useActive();
  const query = useDeferredValue(search.query);
  const found = listed(rows, query, search.order);
  const shelves = Math.max(1, Math.ceil(found.length / SHELF));
  const shelf = Math.min(search.shelf, shelves);
  const shown = found.slice((shelf - 1) * SHELF, shelf * SHELF);
  const compared = ticked.filter((id) => rows.some((row) => row.id === id));
  return (
    <main className="review">
      <div className="bar review-bar">
        <h2 className="bar-title">Recordings</h2>
        <TextInput
          size="xs"
          w={260}
          type="search"
          aria-label="Search recordings"
          placeholder="Name, tag, note, operator, reference"
          data-testid="recording-search"
          value={search.query}
          onChange={(event) => {
            onSearch({ query: event.currentTarget.value, shelf: 1 });
          }}
        />
        <span className="note" role="status" data-testid="recordings-found">
          {found.length === rows.length ? `${rows.length} in all` : `${found.length} of ${rows.length}`}
        </span>
        <span className="spacer" />
        <Button
          size="compact-sm"
          variant="default"
          data-testid="compare"
          disabled={compared.length < 2}
          onClick={() => {
            page.patch({ compared, reviewed: null });
          }}
        >
          Compare {compared.length || ""}
        </Button>
        <Tooltip label="Read the list again">
          <ActionIcon
            variant="subtle"
            color="gray"
            aria-label="Refresh"
            onClick={() => void recordings.load()}
          >
            <IconRefresh size={18} />
          </ActionIcon>
        </Tooltip>
      </div>
      {rows.length === 0 ? (
        <p className="panel note">No recordings yet. Press Record (R) on the Live page.</p>
      ) : (
        <div className="review-list">
          <Table highlightOnHover stickyHeader verticalSpacing={4} data-testid="recordings">
            <Table.Thead>
              <Table.Tr>
                <Table.Th>
                  <span className="sr-only">Compare</span>
                </Table.Th>
                {COLUMNS.map(([column, title]) => (
                  <Title
                    key={column}
                    column={column}
                    title={title}
                    order={search.order}
                    onSearch={onSearch}
                  />
                ))}
                <Table.Th>
                  <span className="sr-only">Actions</span>
                </Table.Th>
              </Table.Tr>
            </Table.Thead>
            <Table.Tbody>
              {shown.map((row) => (
                <RecordingRow
                  key={row.id}
                  row={row}
                  running={row.id === active}
                  recordings={recordings}
                  ticked={compared.includes(row.id)}
                  full={compared.length >= COMPARED_MAX}
                  onTick={(on) => {
                    onTick(on ? [...compared, row.id] : compared.filter((id) => id !== row.id));
                  }}
                />
              ))}
            </Table.Tbody>
          </Table>
          {found.length === 0 ? <p className="panel note">Nothing fits “{query}”.</p> : null}
        </div>
      )}
      {shelves > 1 ? (
        <Pagination
          className="review-shelves"
          size="sm"
          total={shelves}
          value={shelf}
          onChange={(next) => {
            onSearch({ shelf: next });
          }}
          getControlProps={(control) => ({ "aria-label": `${control} page` })}
          getItemProps={(number) => ({ "aria-label": `Page ${number}` })}
        />
      ) : null}
    </main>
  );
}

interface TitleProps {
  readonly column: Column;
  readonly title: string;
  readonly order: Order;
  readonly onSearch: (change: Partial<Search>) => void;
}

function Title({ column, title, order, onSearch }: TitleProps) {
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
          onSearch({ order: nextOrder(order, column), shelf: 1 });
        }}
      >
        {title}
        {chosen ? <Arrow size={12} aria-hidden /> : null}
      </button>
    </Table.Th>
  );
}
