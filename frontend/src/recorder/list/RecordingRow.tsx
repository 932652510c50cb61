import { ActionIcon, Badge, Checkbox, Table, Tooltip, VisuallyHidden } from "@mantine/core";
import { IconDownload, IconStar, IconStarFilled } from "@tabler/icons-react";
import type { MouseEvent } from "react";
import type { Recording } from "../../api/types";
import { PageStore } from "../../live/page";
import { useWhyNot } from "../../operate/permission";
import { bytes, clock, DASH, localTime, millimetres, percent, wholeNumber } from "../../ui/format";
import { useService } from "../../ui/services";
import { recordingUrl } from "../recordings";
import type { Recordings } from "../useRecordings";
import { DeleteButton } from "./DeleteButton";
import { marksOf } from "./listing";

interface Props {
  readonly row: Recording;
  readonly running: boolean;
  readonly recordings: Recordings;
  readonly ticked: boolean;
  /** No more can be ticked. */
  readonly full: boolean;
  readonly onTick: (on: boolean) => void;
}

/** A click anywhere opens it, but on its own controls. */
const own = (event: MouseEvent) => {
  event.stopPropagation();
};

export function RecordingRow({ row, running, recordings, ticked, full, onTick }: Props) {
  const page = useService(PageStore);
  const name = row.name || "unnamed";
  return (
    <Table.Tr
      className="review-row"
      data-testid="recording"
      data-id={row.id}
      onClick={() => {
        page.patch({ reviewed: row.id, compared: [] });
      }}
    >
      <Table.Td onClick={own}>
        <Checkbox
          size="xs"
          aria-label={`Compare ${name}`}
          checked={ticked}
          disabled={full && !ticked}
          onChange={(event) => {
            onTick(event.currentTarget.checked);
          }}
        />
      </Table.Td>
      <Table.Td onClick={own}>
        <Star row={row} recordings={recordings} />
      </Table.Td>
      <Table.Td>
        <button type="button" className="link">
          {name}
        </button>
        <Badges row={row} running={running} />
        {row.problem === "" ? null : <p className="note review-reason">{row.problem}</p>}
      </Table.Td>
      <Table.Td className="number">{localTime(row.started)}</Table.Td>
      <Table.Td>
        {row.actuator || DASH}
        {row.twin ? " · twin" : ""}
      </Table.Td>
      <Table.Td>{row.reference || DASH}</Table.Td>
      <Table.Td className="number right">{row.rows > 0 ? clock(row.seconds) : DASH}</Table.Td>
      <Table.Td className="number right" data-testid="recording-gaps">
        {wholeNumber(row.gaps)}
      </Table.Td>
      <Table.Td className="number right">{millimetres(row.metrics?.rmse, 2)}</Table.Td>
      <Table.Td className="number right">{percent(row.metrics?.on_time_share)}</Table.Td>
      <Table.Td className="number right">{row.bytes > 0 ? bytes(row.bytes) : DASH}</Table.Td>
      <Table.Td className="right review-actions" onClick={own}>
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
        <DeleteButton row={row} running={running} onDelete={() => recordings.remove(row.id)} />
      </Table.Td>
    </Table.Tr>
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
