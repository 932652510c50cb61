import { Button } from "@mantine/core";
import { IconDownload, IconStar, IconStarFilled } from "@tabler/icons-react";
import { memo, type MouseEvent } from "react";
import type { Recording } from "../../api/types";
import { PageStore } from "../../live/page";
import { clock, DASH, localTime, plain, wholeNumber } from "../../ui/format";
import { useService } from "../../ui/services";
import { recordingUrl } from "../recordings";
import type { Recordings } from "../useRecordings";
import { Badges } from "./Badges";
import { DeleteButton } from "./DeleteButton";
import { marksOf, whenText } from "./listing";

interface Props extends Pick<Recordings, "change" | "remove" | "restore"> {
  readonly row: Recording;
  readonly running: boolean;
  readonly ticked: boolean;
  /** It is in the bin. */
  readonly deleted: boolean;
  /** No more can be ticked. */
  readonly full: boolean;
  /** Why nothing can be changed, null when it can. */
  readonly reason: string | null;
  /** Midnight when the day began that is "Today" [ms]. */
  readonly today: number;
  readonly onTick: (id: string, on: boolean) => void;
}

/** A click anywhere opens it, but on its own controls. */
const own = (event: MouseEvent) => event.stopPropagation();

/**
 * One line: what does not fit is cut with dots and said whole on hover. Of plain elements, and drawn again only when
 * something of it has changed: fifty of them with a library's buttons and hints take a quarter of a second.
 */
export const RecordingRow = memo(function RecordingRow(props: Props) {
  const { row, running, deleted, ticked, full, reason, today, change, remove, onTick } = props;
  const page = useService(PageStore);
  const name = row.name || "unnamed";
  const actuator = `${row.actuator || DASH}${row.twin ? " · twin" : ""}`;
  const rmse = plain(scaled(row.metrics?.rmse, 1e3), 2);
  const open = deleted ? undefined : () => { page.patch({ reviewed: row.id, compared: [] }); }; // prettier-ignore
  return (
    <tr className="review-row" data-testid="recording" data-id={row.id} onClick={open}>
      <td className="list-tick" onClick={own}>
        {deleted ? null : (
          <input
            type="checkbox"
            aria-label={`Compare ${name}`}
            data-testid="compare-tick"
            checked={ticked}
            disabled={full && !ticked}
            onChange={(event) => onTick(row.id, event.currentTarget.checked)}
          />
        )}
      </td>
      <td className="list-path">
        <Thumbnail path={row.thumbnail} />
      </td>
      <td className="list-starred" onClick={own}>
        {deleted ? null : <Star row={row} reason={reason} change={change} />}
      </td>
      <td className="list-name">
        <div className="list-line">
          {deleted ? (
            <span title={name}>{name}</span>
          ) : (
            <button type="button" className="link" title={name}>
              {name}
            </button>
          )}
          <Marks row={row} running={running} />
        </div>
      </td>
      <td className="number list-started" title={localTime(row.started)}>
        {whenText(row.started, new Date(today))}
      </td>
      <td className="list-actuator" title={actuator}>
        {actuator}
      </td>
      <td className="list-reference" title={row.reference}>
        {row.reference || DASH}
      </td>
      <td className="number right list-seconds" title={clock(row.seconds)}>
        {row.rows > 0 ? clock(row.seconds) : DASH}
      </td>
      <td className="number right list-gaps" data-testid="recording-gaps">
        {wholeNumber(row.gaps)}
      </td>
      <td className={`number right list-rmse${rmse === DASH ? " missing" : ""}`}>{rmse}</td>
      <td className="number right list-on_time_share">{plain(scaled(row.metrics?.on_time_share, 100), 2)}</td>
      <td className="number right list-bytes">
        {row.bytes > 0 ? plain(row.bytes / 1e6, row.bytes < 1e7 ? 1 : 0) : DASH}
      </td>
      <td className="right list-actions" onClick={own}>
        {deleted ? <RestoreButton {...props} /> : <Actions {...{ row, running, reason, name, remove }} />}
      </td>
    </tr>
  );
});

/** Its marks and tags; those that have no room stand in the title. */
function Marks({ row, running }: Pick<Props, "row" | "running">) {
  const words = [...marksOf(row, running).map(({ text }) => text), ...row.tags.map((tag) => `#${tag}`)];
  if (words.length === 0) return null;
  return (
    <span className="list-marks" title={words.join(", ")}>
      <Badges row={row} running={running} />
    </span>
  );
}

function scaled(value: number | null | undefined, scale: number): number | null {
  return value === null || value === undefined ? null : value * scale;
}

function Actions({
  row,
  running,
  reason,
  name,
  remove,
}: Pick<Props, "row" | "running" | "reason" | "remove"> & { readonly name: string }) {
  // prettier-ignore
  return (
    <>
      <a
        className="icon-button"
        title="Download the .rrd file"
        aria-label={`Download ${name}`}
        href={recordingUrl(row.id, ".rrd")}
        download
      >
        <IconDownload size={16} />
      </a>
      <DeleteButton row={row} running={running} reason={reason} onDelete={() => remove(row)} />
    </>
  );
}

function RestoreButton({ row, reason, restore }: Pick<Props, "row" | "reason" | "restore">) {
  return (
    <Button
      size="compact-xs"
      variant="default"
      disabled={reason !== null}
      title={reason ?? undefined}
      aria-label={`Restore ${row.name || row.id}`}
      data-testid="restore-recording"
      onClick={() => void restore(row)}
    >
      Restore
    </Button>
  );
}

/** Starred recordings are never removed to make room. */
export function Star({ row, reason, change }: Pick<Props, "row" | "reason" | "change">) {
  const Icon = row.starred ? IconStarFilled : IconStar;
  return (
    <button
      type="button"
      className="icon-button"
      disabled={reason !== null}
      title={reason ?? undefined}
      aria-pressed={row.starred}
      aria-label={`Star ${row.name || row.id}`}
      data-testid="star"
      onClick={() => void change(row.id, { starred: !row.starred })}
    >
      <Icon size={15} />
    </button>
  );
}

/** The recording's path, small; nothing where there is none. Its data are the server's, in a box of 100 x 100. */
function Thumbnail({ path }: { readonly path: string | null }) {
  return (
    <svg className="review-thumbnail" viewBox="-6 -6 112 112" width={44} height={26} aria-hidden>
      {path ? <path d={path} vectorEffect="non-scaling-stroke" /> : null}
    </svg>
  );
}
