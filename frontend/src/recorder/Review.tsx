import { Button, CloseButton, Loader } from "@mantine/core";
import { useWindowEvent } from "@mantine/hooks";
import { useCallback, useEffect, useState } from "react";
import type { Recording } from "../api/types";
import { PageStore, usePage } from "../live/page";
import { focusOf } from "../operate/target/keys";
import { useService } from "../ui/services";
import { Compare } from "./compare/Compare";
import { Detail } from "./detail/Detail";
import { NEWEST } from "./list/listing";
import { RecordingList, SHELF } from "./list/RecordingList";
import { useRecordings, type Recordings, type Search } from "./useRecordings";

/** The recordings: as a list, one, or up to four side by side. */
export default function Review() {
  const page = useService(PageStore);
  const reviewed = usePage((state) => state.reviewed);
  const compared = usePage((state) => state.compared);
  const [search, setSearch] = useState<Search>({ query: "", order: NEWEST, limit: SHELF, deleted: false });
  const [ticked, setTicked] = useState<readonly string[]>([]);
  const opened = compared.length > 0 ? compared : reviewed === null ? [] : [reviewed];
  const recordings = useRecordings(search, opened);
  const tick = useCallback((id: string, on: boolean) => {
    setTicked((old) => (on ? [...old, id] : old.filter((one) => one !== id)));
  }, []);
  const back = () => page.patch({ reviewed: null, compared: [] });
  const known = opened.map(recordings.find);
  const waits = opened.length > 0 ? known.includes(undefined) : recordings.listed === null;
  if (waits) return recordings.problem === "" ? <Loader m="xl" /> : <Unread {...recordings} />;
  const { justDeleted } = recordings;
  return (
    <>
      {compared.length > 0 ? (
        <Compare ids={compared} recordings={recordings} onBack={back} />
      ) : reviewed !== null ? (
        <Detail key={reviewed} id={reviewed} recordings={recordings} onBack={back} />
      ) : (
        <RecordingList
          recordings={recordings}
          search={search}
          onSearch={(change) => setSearch({ ...search, ...change })}
          ticked={ticked.filter((id) => recordings.find(id) !== null)}
          onTick={tick}
        />
      )}
      {justDeleted ? <Undo row={justDeleted} recordings={recordings} /> : null}
    </>
  );
}

/** How long the last deletion can be undone by one click [ms]; afterwards it stands under "Deleted". */
const UNDO_MS = 20_000;

interface UndoProps {
  readonly row: Recording;
  readonly recordings: Recordings;
}

function Undo({ row, recordings: { restore, forgetDeleted } }: UndoProps) {
  useWindowEvent("keydown", (event) => {
    if (!isUndo(event) || focusOf(document.activeElement) === "text") return;
    event.preventDefault();
    void restore(row);
  });
  useEffect(() => {
    const gone = setTimeout(forgetDeleted, UNDO_MS);
    return () => {
      clearTimeout(gone);
    };
  }, [row, forgetDeleted]);
  return (
    <div className="review-undo" role="status" data-testid="undo-deletion">
      <span className="cut" title={row.name}>
        Deleted “{row.name || row.id}”
      </span>
      <Button
        size="compact-sm"
        variant="default"
        title="Undo (Ctrl Z)"
        data-testid="undo-delete"
        onClick={() => void restore(row)}
      >
        Undo
      </Button>
      <CloseButton size="sm" aria-label="Close" onClick={forgetDeleted} />
    </div>
  );
}

function isUndo({ ctrlKey, metaKey, shiftKey, key }: KeyboardEvent): boolean {
  return (ctrlKey || metaKey) && !shiftKey && key.toLowerCase() === "z";
}

interface UnreadProps {
  readonly problem: string;
  readonly load: () => void;
}

function Unread({ problem, load }: UnreadProps) {
  return (
    <main className="review">
      <div className="panel" role="alert">
        <p className="advice">The recordings cannot be listed: {problem}</p>
        <Button size="xs" variant="default" w="fit-content" onClick={load}>
          Try again
        </Button>
      </div>
    </main>
  );
}
