import { ActionIcon, Button, Chip, Popover, TextInput, Tooltip } from "@mantine/core";
import { IconArrowDown, IconArrowUp, IconRefresh } from "@tabler/icons-react";
import type { KeyboardEvent } from "react";
import { PageStore } from "../../live/page";
import { useWhyNot } from "../../operate/permission";
import { useService } from "../../ui/services";
import { COMPARED_MAX } from "../place";
import type { Listed } from "../recordings";
import { useActive, type Recordings, type Search } from "../useRecordings";
import { ImportButton } from "./ImportButton";
import { RecordingRow } from "./RecordingRow";
import { useTabStop } from "../../ui/buttons/tabStop";
import { nextOrder, type Column, type Order } from "./listing";

/** Rows shown at once: thousands of recordings stay fluid. */
export const SHELF = 50;
const NONE: Listed = { rows: [], found: 0, inAll: 0, deleted: 0, sort: "" };

interface Props {
  readonly recordings: Recordings;
  readonly search: Search;
  readonly onSearch: (change: Partial<Search>) => void;
  readonly ticked: readonly string[];
  readonly onTick: (id: string, on: boolean) => void;
}

/** The list with search, order and ticks, as the server finds it. */
export function RecordingList({ recordings, search, onSearch, ticked, onTick }: Props) {
  const active = useActive();
  const keys = useRowKeys();
  const reason = useWhyNot("edit");
  const today = new Date().setHours(0, 0, 0, 0);
  const { rows, found, inAll, sort } = recordings.listed ?? NONE;
  const { change, remove, restore } = recordings;
  return (
    <main className="review">
      <ListBar recordings={recordings} search={search} onSearch={onSearch} ticked={ticked} />
      {inAll === 0 ? (
        <p className="panel note">
          {search.deleted ? "Nothing is deleted." : "No recordings yet. Press Record (R) on the Live page."}
        </p>
      ) : (
        <div className="review-list">
          <table className="list-table" data-testid="recordings" data-sort={sort}>
            <Titles order={search.order} onOrder={(order) => onSearch({ order, limit: SHELF })} />
            <tbody {...keys}>
              {rows.map((row) => (
                <RecordingRow
                  key={row.id}
                  row={row}
                  running={row.id === active}
                  deleted={search.deleted}
                  ticked={ticked.includes(row.id)}
                  full={ticked.length >= COMPARED_MAX}
                  reason={reason}
                  today={today}
                  {...{ change, remove, restore, onTick }}
                />
              ))}
            </tbody>
          </table>
          {found === 0 ? <p className="panel note">Nothing fits “{search.query}”.</p> : null}
          {rows.length < found ? (
            <Button
              className="review-more"
              size="xs"
              variant="default"
              data-testid="show-more"
              onClick={() => onSearch({ limit: rows.length + SHELF })}
            >
              Show {Math.min(SHELF, found - rows.length)} more
            </Button>
          ) : null}
        </div>
      )}
    </main>
  );
}

type BarProps = Omit<Props, "onTick">;

function ListBar({ recordings, search, onSearch, ticked }: BarProps) {
  const page = useService(PageStore);
  return (
    <div className="bar review-bar">
      <h2 className="bar-title review-title" tabIndex={-1} data-focus-home>
        Recordings
      </h2>
      <TextInput
        size="xs"
        className="review-search"
        type="search"
        aria-label="Search recordings"
        placeholder="Name, tag, note, operator, reference"
        data-testid="recording-search"
        maxLength={200}
        value={search.query}
        onChange={(event) => onSearch({ query: event.currentTarget.value, limit: SHELF })}
      />
      <span className="note" role="status" data-testid="recordings-found">
        {recordings.problem === "" ? countOf(recordings.listed ?? NONE) : `Not read: ${recordings.problem}`}
      </span>
      <DeletedSwitch recordings={recordings} search={search} onSearch={onSearch} />
      <span className="spacer" />
      <ImportButton recordings={recordings} />
      <Button
        size="compact-sm"
        variant="default"
        className="review-compare"
        data-testid="compare"
        disabled={ticked.length < 2}
        title={ticked.length < 2 ? `Tick two to ${COMPARED_MAX} recordings` : ""}
        onClick={() => page.patch({ compared: ticked, reviewed: null })}
      >
        Compare {ticked.length || ""}
      </Button>
      <Tooltip label="Read the list again">
        <ActionIcon variant="subtle" color="gray" aria-label="Refresh" onClick={recordings.load}>
          <IconRefresh size={18} />
        </ActionIcon>
      </Tooltip>
    </div>
  );
}

/** Shows what was deleted instead, and there removes all of it for good. */
function DeletedSwitch({ recordings, search, onSearch }: Pick<Props, "recordings" | "search" | "onSearch">) {
  const reason = useWhyNot("edit");
  const count = recordings.listed?.deleted ?? 0;
  return (
    <>
      <Chip
        size="xs"
        checked={search.deleted}
        data-testid="show-deleted"
        onChange={(deleted) => onSearch({ deleted, limit: SHELF })}
      >
        Deleted{count > 0 ? ` (${count})` : ""}
      </Chip>
      {search.deleted && count > 0 ? (
        <Popover position="bottom" shadow="md" trapFocus withinPortal>
          <Popover.Target>
            <Button size="compact-sm" variant="default" data-testid="empty-bin">
              Remove for good
            </Button>
          </Popover.Target>
          <Popover.Dropdown aria-label="Remove them for good?">
            <p className="note">{reason ?? `${count} deleted recordings cannot be restored then.`}</p>
            <Button
              size="compact-sm"
              mt={6}
              color="red"
              data-testid="empty-bin-confirm"
              disabled={reason !== null}
              onClick={() => void recordings.emptyBin()}
            >
              Remove for good
            </Button>
          </Popover.Dropdown>
        </Popover>
      ) : null}
    </>
  );
}

/** "100 of 5002", "2 found, 5002 in all" */
function countOf({ rows, found, inAll }: Listed): string {
  const shown = rows.length < found ? `${rows.length} of ` : "";
  return found === inAll ? `${shown}${inAll} in all` : `${shown}${found} found, ${inAll} in all`;
}

const CONTROLS = "a, button, input";
const STEPS: Partial<Record<string, "previousElementSibling" | "nextElementSibling">> = {
  ArrowUp: "previousElementSibling",
  ArrowDown: "nextElementSibling",
};

/** For the body of a table: up and down go along its column, and Tab stops in one row only, the last that was used. */
function useRowKeys() {
  const stop = useTabStop(
    (body: HTMLTableSectionElement) => [...body.rows],
    (row) => row.querySelectorAll<HTMLElement>(CONTROLS),
  );
  return {
    ...stop,
    onKeyDown: (event: KeyboardEvent) => {
      const step = STEPS[event.key];
      const cell = event.target instanceof Element ? event.target.closest("td") : null;
      if (!step || !cell) return;
      event.preventDefault();
      cell.parentElement?.[step]?.children
        .item(cell.cellIndex)
        ?.querySelector<HTMLElement>(CONTROLS)
        ?.focus();
    },
  };
}

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

interface TitlesProps {
  readonly order: Order;
  readonly onOrder: (order: Order) => void;
}

/** Titles of the list's columns: a click sorts, another one turns the order round. */
function Titles({ order, onOrder }: TitlesProps) {
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

interface TitleProps extends TitlesProps {
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
        onClick={() => onOrder(nextOrder(order, column))}
      >
        {title} {unit === "" ? null : <span className="unit">{unit}</span>}
        {chosen ? <Arrow size={12} aria-hidden /> : null}
      </button>
    </th>
  );
}
