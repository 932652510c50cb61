import { useCallback, useEffect, useState } from "react";
import { recordings, type RecordingChanges } from "../api/recordings";
import type { Recording } from "../api/types";
import { useDashboard, usePage } from "../panels/context";

export interface Recordings {
  /** Null before the first answer. */
  readonly rows: readonly Recording[] | null;
  /** Why there is no list, "" when there is. */
  readonly problem: string;
  readonly load: () => Promise<void>;
  readonly change: (id: string, changes: RecordingChanges) => Promise<void>;
  readonly remove: (id: string) => Promise<void>;
}

/** The list of recordings: read when the tab opens and when a recording starts or stops. */
export function useRecordings(): Recordings {
  const { operations } = useDashboard();
  const active = useActive();
  const [rows, setRows] = useState<readonly Recording[] | null>(null);
  const [problem, setProblem] = useState("");
  const load = useCallback(
    () =>
      recordings.list().then(
        (found) => {
          setRows(found);
          setProblem("");
        },
        (error: unknown) => {
          setProblem(error instanceof Error ? error.message : String(error));
        },
      ),
    [],
  );
  useEffect(() => {
    void load();
  }, [load, active]);
  const change = (id: string, changes: RecordingChanges) =>
    operations.attempt("Recording not changed", async () => {
      const changed = await recordings.change(id, changes);
      setRows((old) => old && old.map((row) => (row.id === id ? changed : row)));
    });
  const remove = (id: string) =>
    operations.attempt("Recording not deleted", async () => {
      await recordings.remove(id);
      setRows((old) => old && old.filter((row) => row.id !== id));
    });
  return { rows, problem, load, change, remove };
}

/** Id of the recording that is being written, "" for none. */
export function useActive(): string {
  return usePage((page) => (page.recording.recording ? page.recording.id : ""));
}
