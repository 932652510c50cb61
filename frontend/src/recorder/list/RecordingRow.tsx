import { ActionIcon, Badge, Button, Checkbox, Table, Tooltip, VisuallyHidden } from "@mantine/core";
import { IconDownload, IconStar, IconStarFilled } from "@tabler/icons-react";
import type { MouseEvent } from "react";
import type { Recording } from "../../api/types";
import { PageStore } from "../../live/page";
import { useWhyNot } from "../../operate/permission";
import { clock, DASH, localTime, plain, wholeNumber } from "../../ui/format";
import { useService } from "../../ui/services";
import { recordingUrl } from "../recordings";
import type { Recordings } from "../useRecordings";
import { DeleteButton } from "./DeleteButton";
import { marksOf, whenText } from "./listing";
import { Thumbnail } from "./Thumbnail";

interface Props {
  readonly row: Recording;
  readonly running: boolean;
  readonly recordings: Recordings;
  readonly ticked: boolean;
  /** It is in the bin. */
  readonly deleted: boolean;
  /** No more can be ticked. */
  readonly full: boolean;
  readonly onTick: (on: boolean) => void;
}

/** A click anywhere opens it, but on its own controls. */
const own = (event: MouseEvent) => {
  event.stopPropagation();
};

/** One line: what does not fit is cut with dots and said whole on hover. */
export function RecordingRow({ row, running, recordings, deleted, ticked, full, onTick }: Props) {
  const page = useService(PageStore);
  const name = row.name || "unnamed";
  const open = deleted ? undefined : () => { page.patch({ reviewed: row.id, compared: [] }); }; // prettier-ignore
  return (
    <Table.Tr className="review-row" data-testid="recording" data-id={row.id} onClick={open}>
      <Table.Td className="list-tick" onClick={own}>
        {deleted ? null : (
          <Checkbox
            size="xs"
            aria-label={`Compare ${name}`}
            data-testid="compare-tick"
            checked={ticked}
            disabled={full && !ticked}
            onChange={(event) => {
              onTick(event.currentTarget.checked);
            }}
          />
        )}
      </Table.Td>
      <Table.Td className="list-path">
        <Thumbnail path={row.thumbnail} />
      </Table.Td>
      <Table.Td className="list-starred" onClick={own}>
        {deleted ? null : <Star row={row} recordings={recordings} />}
      </Table.Td>
      <Table.Td className="list-name">
        <div className="list-line">
          {deleted ? (
            <span title={name}>{name}</span>
          ) : (
            <button type="button" className="link" title={name}>
              {name}
            </button>
          )}
          <Badges row={row} running={running} />
        </div>
      </Table.Td>
      <Table.Td className="number list-started" title={localTime(row.started)}>
        {whenText(row.started, new Date())}
      </Table.Td>
      <Table.Td className="list-actuator" title={row.actuator}>
        {row.actuator || DASH}
        {row.twin ? " · twin" : ""}
      </Table.Td>
      <Table.Td className="list-reference" title={row.reference}>
        {row.reference || DASH}
      </Table.Td>
      <Table.Td className="number right list-seconds">{row.rows > 0 ? clock(row.seconds) : DASH}</Table.Td>
      <Table.Td className="number right list-gaps" data-testid="recording-gaps">
        {wholeNumber(row.gaps)}
      </Table.Td>
      <Table.Td className="number right list-rmse">{plain(scaled(row.metrics?.rmse, 1e3), 2)}</Table.Td>
      <Table.Td className="number right list-on_time_share">
        {plain(scaled(row.metrics?.on_time_share, 100), 2)}
      </Table.Td>
      <Table.Td className="number right list-bytes">
        {row.bytes > 0 ? plain(row.bytes / 1e6, row.bytes < 1e7 ? 1 : 0) : DASH}
      </Table.Td>
      <Table.Td className="right list-actions" onClick={own}>
        {deleted ? (
          <RestoreButton row={row} recordings={recordings} />
        ) : (
          <>
            <Tooltip label="Download the .rrd file">
              <ActionIcon
                component="a"
                variant="subtle"
                color="gray"
                aria-label={`Download ${name}`}
                href={recordingUrl(row.id, ".rrd")}
                download
              >
                <IconDownload size={16} />
              </ActionIcon>
            </Tooltip>
            <DeleteButton row={row} running={running} onDelete={() => recordings.remove(row)} />
          </>
        )}
      </Table.Td>
    </Table.Tr>
  );
}

function scaled(value: number | null | undefined, scale: number): number | null {
  return value === null || value === undefined ? null : value * scale;
}

function RestoreButton({ row, recordings }: Pick<Props, "row" | "recordings">) {
  const reason = useWhyNot("edit");
  return (
    <Button
      size="compact-xs"
      variant="default"
      disabled={reason !== null}
      title={reason ?? undefined}
      aria-label={`Restore ${row.name || row.id}`}
      data-testid="restore-recording"
      onClick={() => void recordings.restore(row)}
    >
      Restore
    </Button>
  );
}

interface StarProps {
  readonly row: Recording;
  readonly recordings: Recordings;
}

/** Starred recordings are never removed to make room. */
export function Star({ row, recordings }: StarProps) {
  const reason = useWhyNot("edit");
  const Icon = row.starred ? IconStarFilled : IconStar;
  return (
    <ActionIcon
      variant="subtle"
      color={row.starred ? "yellow" : "gray"}
      size="sm"
      disabled={reason !== null}
      title={reason ?? undefined}
      aria-pressed={row.starred}
      aria-label={`Star ${row.name || row.id}`}
      data-testid="star"
      onClick={() => void recordings.change(row.id, { starred: !row.starred })}
    >
      <Icon size={15} />
    </ActionIcon>
  );
}

interface BadgesProps {
  readonly row: Recording;
  readonly running: boolean;
}

export function Badges({ row, running }: BadgesProps) {
  return (
    <>
      {marksOf(row, running).map(({ text, reason, bad }) => (
        <Tooltip key={text} label={reason} multiline maw={420}>
          <Badge
            className={bad ? "review-badge review-bad" : "review-badge"}
            size="sm"
            variant="default"
            tt="none"
            data-testid="mark"
          >
            {bad ? "▲ " : ""}
            {text}
            <VisuallyHidden>: {reason}</VisuallyHidden>
          </Badge>
        </Tooltip>
      ))}
      {row.tags.map((tag) => (
        <span key={tag} className="note review-tag">
          #{tag}
        </span>
      ))}
    </>
  );
}
