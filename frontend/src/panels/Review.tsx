import {
  ActionIcon,
  Button,
  Loader,
  SegmentedControl,
  Table,
  Tooltip,
  useComputedColorScheme,
} from "@mantine/core";
import { IconArrowLeft, IconDownload, IconRefresh } from "@tabler/icons-react";
import { useCallback, useEffect, useState } from "react";
import { rest, viewerUrl } from "../api/rest";
import type { Recording } from "../api/types";
import { bytes, clock, DASH, localTime, wholeNumber } from "../state/format";
import { Replay3D } from "./Replay3D";
import { useDashboard, usePage } from "./context";

/** The recordings, newest first; one opens in rerun's own viewer, inside the page. */
export default function Review() {
  const dashboard = useDashboard();
  const active = usePage((page) => (page.recording.recording ? page.recording.id : ""));
  const [rows, setRows] = useState<readonly Recording[] | null>(null);
  const reviewed = usePage((page) => page.reviewed);
  const opened = rows?.find(({ id }) => id === reviewed);
  const load = useCallback(async () => {
    await dashboard.operations.attempt("Recordings not listed", async () => {
      const found = await rest.recordings();
      setRows(found.toSorted((a, b) => b.started.localeCompare(a.started)));
    });
  }, [dashboard]);
  useEffect(() => {
    // The list is outside React: fetched when the tab opens and when a recording starts or stops.

    void load();
  }, [load, active]);
  const open = (id: string | null) => {
    dashboard.page.patch({ reviewed: id });
  };
  if (opened) return <Viewer recording={opened} onClose={() => { open(null); }} />; // prettier-ignore
  return (
    <main className="review">
      <div className="bar">
        <span className="bar-title">Recordings</span>
        <span className="spacer" />
        <Tooltip label="Read the list again">
          <ActionIcon variant="subtle" color="gray" aria-label="Refresh" onClick={() => void load()}>
            <IconRefresh size={18} />
          </ActionIcon>
        </Tooltip>
      </div>
      <List
        rows={rows}
        active={active}
        onOpen={({ id }) => {
          open(id);
        }}
      />
    </main>
  );
}

interface ListProps {
  readonly rows: readonly Recording[] | null;
  readonly active: string;
  readonly onOpen: (recording: Recording) => void;
}

function List({ rows, active, onOpen }: ListProps) {
  if (rows === null) return <Loader m="xl" />;
  if (rows.length === 0)
    return <p className="panel note">No recordings yet. Press Record (R) on the Live page.</p>;
  return (
    <div className="review-list">
      <Table highlightOnHover stickyHeader verticalSpacing={6} data-testid="recordings">
        <Table.Thead>
          <Table.Tr>
            {["Name", "Time", "Actuator", "Duration", "Rows", "Gaps", "Size", ""].map((title, i) => (
              <Table.Th key={i} className={i >= 3 && i <= 6 ? "right" : ""}>
                {title}
              </Table.Th>
            ))}
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {rows.map((row) => (
            <Row key={row.id} row={row} running={row.id === active} onOpen={onOpen} />
          ))}
        </Table.Tbody>
      </Table>
    </div>
  );
}

interface RowProps {
  readonly row: Recording;
  readonly running: boolean;
  readonly onOpen: (recording: Recording) => void;
}

function Row({ row, running, onOpen }: RowProps) {
  const note = running ? " (recording now)" : row.complete ? "" : " (cut short)";
  return (
    <Table.Tr
      className="review-row"
      data-testid="recording"
      data-id={row.id}
      onClick={() => {
        onOpen(row);
      }}
    >
      <Table.Td>
        <button type="button" className="link">
          {row.name || "unnamed"}
        </button>
        <span className="note">{note}</span>
      </Table.Td>
      <Table.Td className="number">{localTime(row.started)}</Table.Td>
      <Table.Td>
        {row.actuator}
        {row.twin ? " · twin" : ""}
      </Table.Td>
      <Table.Td className="number right">{row.rows > 0 ? clock(row.seconds) : DASH}</Table.Td>
      <Table.Td className="number right">{wholeNumber(row.rows)}</Table.Td>
      <Table.Td className="number right">{wholeNumber(row.gaps)}</Table.Td>
      <Table.Td className="number right">{bytes(row.bytes)}</Table.Td>
      <Table.Td className="right">
        <Tooltip label="Download the .rrd file">
          <ActionIcon
            component="a"
            variant="subtle"
            color="gray"
            aria-label={`Download ${row.name || row.id}`}
            href={`/api/recordings/${encodeURIComponent(row.id)}.rrd`}
            download
            onClick={(event) => {
              event.stopPropagation();
            }}
          >
            <IconDownload size={16} />
          </ActionIcon>
        </Tooltip>
      </Table.Td>
    </Table.Tr>
  );
}

type Sight = "plots" | "3d";

interface ViewerProps {
  readonly recording: Recording;
  readonly onClose: () => void;
}

/** A recording: its signals in rerun, or its motion in 3D. */
function Viewer({ recording, onClose }: ViewerProps) {
  const [sight, setSight] = useState<Sight>("plots");
  return (
    <main className="review">
      <div className="bar">
        <Button
          variant="subtle"
          size="xs"
          leftSection={<IconArrowLeft size={16} />}
          onClick={onClose}
          data-testid="back"
        >
          Recordings
        </Button>
        <span className="bar-title">
          {recording.name || "unnamed"} · {localTime(recording.started)} · {clock(recording.seconds)}
        </span>
        <span className="spacer" />
        <SegmentedControl
          size="xs"
          aria-label="Show the recording as"
          data-testid="sight"
          value={sight}
          onChange={setSight}
          data={[
            { value: "plots", label: "Signals" },
            { value: "3d", label: "3D" },
          ]}
        />
      </div>
      {sight === "plots" ? <Signals recording={recording} /> : <Replay3D recording={recording} />}
    </main>
  );
}

function Signals({ recording }: { readonly recording: Recording }) {
  const scheme = useComputedColorScheme("dark");
  const [ready, setReady] = useState(false);
  useEffect(() => {
    const hear = (event: MessageEvent<unknown>) => {
      if (event.origin === window.location.origin && event.data === "READY") setReady(true);
    };
    window.addEventListener("message", hear);
    return () => {
      window.removeEventListener("message", hear);
    };
  }, []);
  const renderer = new URLSearchParams(window.location.search).get("rerun_renderer");
  return (
    <>
      {ready ? null : <Loader size="xs" m="xs" data-testid="viewer-loading" />}
      <iframe
        className="viewer-frame"
        title="Recording in rerun"
        data-testid="viewer"
        data-ready={ready}
        src={viewerUrl(window.location.origin, recording.id, scheme, renderer)}
      />
    </>
  );
}
