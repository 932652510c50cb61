import { useEffect, useMemo, useState } from "react";
import type { ImportChoices, ImportProposal } from "../../api/types";
import { textOf } from "../../ui/format";
import { ColumnTable } from "./ColumnTable";
import { ImportFrame, type Found } from "./ImportFrame";
import { chosen, openQuestion, propose } from "./proposal";

interface Props {
  readonly file: File;
  readonly onClose: () => void;
}

interface Answer {
  readonly proposal: ImportProposal;
  /** What it answers. */
  readonly to: ImportChoices;
}

/** A table: which columns are x, y and time, in which units, as the server reads it. */
export function TableImport({ file, onClose }: Props) {
  const [choices, setChoices] = useState<ImportChoices>({});
  const [answer, setAnswer] = useState<Answer | null>(null);
  const [refusal, setRefusal] = useState("");
  useEffect(() => {
    let current = true;
    propose(file, choices).then(
      (proposal) => {
        if (!current) return;
        setAnswer({ proposal, to: choices });
        setRefusal("");
      },
      (error: unknown) => {
        if (current) setRefusal(textOf(error));
      },
    );
    return () => {
      current = false;
    };
  }, [file, choices]);
  const shown = useMemo(() => (answer ? shownOf(answer, choices) : null), [answer, choices]);
  const found = useMemo(() => (answer ? foundIn(answer.proposal) : null), [answer]);
  const reading = refusal === "" && answer?.to !== choices ? "Reading the file" : "";
  const question = shown ? openQuestion(shown.columns) || reading : reading;
  const problem = refusal || (shown && asked(shown) ? "" : (shown?.problem ?? ""));
  return (
    <ImportFrame file={file} found={found} question={question} problem={problem} onClose={onClose}>
      {shown ? (
        <ColumnTable proposal={shown} onChoose={(choice) => setChoices({ ...choices, ...choice })} />
      ) : null}
    </ImportFrame>
  );
}

/** The proposal; while the server reads the file again, the columns as chosen and no row as read. */
function shownOf({ proposal, to }: Answer, choices: ImportChoices): ImportProposal {
  if (to === choices) return proposal;
  const rows = proposal.rows.map((row) => ({ ...row, t: null, point: null }));
  return { ...proposal, columns: chosen(proposal.columns, choices), rows, problem: "" };
}

/** There is no path only because no one has said yet which columns are x and y. */
function asked({ path, columns }: ImportProposal): boolean {
  return path === null && !["x", "y"].every((name) => columns.some((column) => column.name === name));
}

function foundIn({ path, count, times_problem }: ImportProposal): Found | null {
  if (!path) return null;
  const notes = path.notes.filter((note) => !note.includes("has no unit")); // chosen above the rows
  return { strokes: [path.points], times: path.times, timesProblem: times_problem, rows: count, notes };
}
