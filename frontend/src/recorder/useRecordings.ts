import { useDebouncedValue } from "@mantine/hooks";
import { useCallback, useEffect, useMemo, useRef, useState } from "react";
import { Refusal } from "../api/rest";
import type { Recording } from "../api/types";
import { keep, usePage } from "../live/page";
import { Operations } from "../operate/operations";
import { textOf } from "../ui/format";
import { useService } from "../ui/services";
import { isSettled, sortOf, wantsPicture, type Order } from "./list/listing";
import { recordings, type Listed, type RecordingChanges } from "./recordings";

export interface Search {
  readonly query: string;
  readonly order: Order;
  /** Most rows. */
  readonly limit: number;
  /** Those in the bin instead. */
  readonly deleted: boolean;
}

/** What is shown, and what can be done with it; functions stay the same ones. */
export interface Recordings {
  /** Null before the first answer. */
  readonly listed: Listed | null;
  /** Why nothing can be read, "" when it can. */
  readonly problem: string;
  /** The recording `id`: undefined until the server said, null when there is none. */
  readonly find: (id: string) => Recording | null | undefined;
  /** Read again. */
  readonly load: () => void;
  readonly change: (id: string, changes: RecordingChanges) => Promise<void>;
  readonly remove: (row: Recording) => Promise<void>;
  /** Give bookmark `n` of a recording a label, or with null remove it. */
  readonly label: (id: string, n: number, label: string | null) => Promise<void>;
  readonly restore: (row: Recording) => Promise<void>;
  readonly emptyBin: () => Promise<void>;
  /** What was deleted last, while that can be undone here; null once it is no news. */
  readonly justDeleted: Recording | null;
  readonly forgetDeleted: () => void;
}

/** How long the typing rests before the server is asked [ms]. */
const TYPING_MS = 80;
/** How often what is being written or measured is read again [ms]. */
const REFRESH_MS = 2000;
/** So often at most the list is read again for pictures that are being made. */
const PICTURE_READS = 20;

type Opened = Readonly<Record<string, Recording | null>>;

/** The list that was searched, or the `opened` recordings; read again when a recording starts, grows or is measured. */
export function useRecordings(search: Search, opened: readonly string[]): Recordings {
  const operations = useService(Operations);
  const active = useActive();
  const [listed, setListed] = useState<Listed | null>(null);
  const [known, setKnown] = useState<Opened>({});
  const [problem, setProblem] = useState("");
  const [query] = useDebouncedValue(search.query, TYPING_MS);
  const sort = sortOf(search.order);
  const { limit, deleted } = search;
  const [justDeleted, setJustDeleted] = useState<Recording | null>(null);
  const pictureReads = useRef(0);
  const wanted = opened.join(",");
  const [turn, setTurn] = useState(0);
  const load = useCallback(() => {
    setTurn((old) => old + 1);
  }, []);

  const find = (id: string) => {
    const row = listed?.rows.find((one) => one.id === id);
    return known[id] ?? row ?? known[id];
  };

  useEffect(() => {
    let late = false; // something else was asked: its answer counts
    const ids = wanted === "" ? [] : wanted.split(",");
    const answer = ids.length > 0 ? readOpened(ids) : recordings.list(query, sort, limit, deleted);
    answer.then(
      (found) => {
        if (late) return;
        if (isListed(found)) setListed((old) => withKept(old, found));
        else setKnown((old) => ({ ...old, ...found }));
        setProblem("");
      },
      (error: unknown) => {
        if (!late) setProblem(textOf(error));
      },
    );
    return () => {
      late = true;
    };
  }, [wanted, query, sort, limit, deleted, active, turn]);
  useEffect(() => {
    const shown = wanted === "" ? (listed?.rows ?? []) : wanted.split(",").map((id) => known[id]);
    const grows = (row: Recording | null | undefined) =>
      row && (row.id === active || !isSettled(row, Date.now()));
    const pictured = (row: Recording | null | undefined) => row && !deleted && wantsPicture(row);
    const waits = pictureReads.current < PICTURE_READS && shown.some(pictured);
    if (!shown.some(grows) && !waits) return undefined;
    if (waits) pictureReads.current += 1;
    const again = setTimeout(load, REFRESH_MS);
    return () => {
      clearTimeout(again);
    };
  }, [load, active, wanted, listed, known, deleted]);

  const actions = useMemo(() => {
    const put = (id: string, changed: Recording | null) => {
      setKnown((old) => ({ ...old, [id]: changed }));
      setListed((old) => old && withRow(old, id, changed));
    };
    const forgetDeleted = () => setJustDeleted(null);
    const change = (id: string, changes: RecordingChanges) =>
      operations.attempt("Recording not changed", async () => {
        put(id, await recordings.change(id, changes));
      });
    const label = (id: string, n: number, text: string | null) =>
      operations.attempt("Bookmark not changed", async () => {
        put(id, await recordings.label(id, n, text));
      });
    const remove = (row: Recording) =>
      operations.attempt("Recording not deleted", async () => {
        await recordings.remove(row.id);
        put(row.id, null);
        setListed((old) => old && { ...old, deleted: old.deleted + 1 });
        setJustDeleted(row);
      });
    const restore = (row: Recording) =>
      operations.attempt("Recording not restored", async () => {
        await recordings.restore(row.id);
        setKnown((old) => ({ ...old, [row.id]: row }));
        forgetDeleted();
        load();
      });
    const emptyBin = () =>
      operations.attempt("Deleted recordings not removed", async () => {
        await recordings.emptyBin();
        forgetDeleted();
        load();
      });
    return { change, label, remove, restore, emptyBin, forgetDeleted };
  }, [operations, load]);
  return { listed, problem, find, load, justDeleted, ...actions };
}

/** Id of the recording that is being written, "" for none. */
export function useActive(): string {
  return usePage((page) => (page.recording.recording ? page.recording.id : ""));
}

async function readOpened(ids: readonly string[]): Promise<Opened> {
  const found = await Promise.all(
    ids.map(async (id): Promise<[string, Recording | null]> => [id, await findOne(id)]),
  );
  return Object.fromEntries(found);
}

async function findOne(id: string): Promise<Recording | null> {
  try {
    return await recordings.find(id);
  } catch (error) {
    if (error instanceof Refusal && error.status === 404) return null;
    throw error;
  }
}

function isListed(found: Listed | Opened): found is Listed {
  return "inAll" in found && typeof found.inAll === "number";
}

function withRow(listed: Listed, id: string, changed: Recording | null): Listed {
  const { rows, found, inAll } = listed;
  if (changed) return { ...listed, rows: rows.map((row) => (row.id === id ? changed : row)) };
  const left = rows.filter((row) => row.id !== id);
  const gone = rows.length - left.length;
  return { ...listed, rows: left, found: found - gone, inAll: inAll - gone };
}

/** `found`, in which what has not changed is as it was: nothing of it is drawn again. */
function withKept(old: Listed | null, found: Listed): Listed {
  const before = new Map(old?.rows.map((row) => [row.id, row]));
  return { ...found, rows: found.rows.map((row) => keep(before.get(row.id) ?? row, row)) };
}
