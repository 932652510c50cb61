import { useEffect, useMemo, useState } from "react";
import type { ImportChoices, ImportProposal } from "../../api/types";
import { textOf } from "../../ui/format";
import { ColumnTable } from "./ColumnTable";
import { ImportFrame, type Found } from "./ImportFrame";
import { openQuestion, propose } from "./proposal";

interface Props {
  readonly file: File;
  readonly onClose: () => void;
}

/** A table: which columns are x, y and time, in which units, as the server reads it. */
export function TableImport({ file, onClose }: Props) {
  const [choices, setChoices] = useState<ImportChoices>({});
  const [proposal, setProposal] = useState<ImportProposal | null>(null);
  const [refusal, setRefusal] = useState("");
  useEffect(() => {
    let current = true;
    propose(file, choices).then(
      (said) => {
        if (!current) return;
        setProposal(said);
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
  const found = useMemo(() => (proposal ? foundIn(proposal) : null), [proposal]);
  const question = proposal ? openQuestion(proposal.columns) : refusal === "" ? "Reading the file" : "";
  const problem = refusal || (proposal && asked(proposal) ? "" : (proposal?.problem ?? ""));
  return (
    <ImportFrame file={file} found={found} question={question} problem={problem} onClose={onClose}>
      {proposal ? (
        <ColumnTable
          proposal={proposal}
          onChoose={(choice) => {
            setChoices((before) => ({ ...before, ...choice }));
          }}
        />
      ) : null}
    </ImportFrame>
  );
}

/** There is no path only because nobody has said yet which columns are x and y. */
function asked({ path, columns }: ImportProposal): boolean {
  return path === null && !["x", "y"].every((name) => columns.some((column) => column.name === name));
}

function foundIn({ path, count, times_problem }: ImportProposal): Found | null {
  if (!path) return null;
  const notes = path.notes.filter((note) => !note.includes("has no unit")); // chosen above the rows
  return { strokes: [path.points], times: path.times, timesProblem: times_problem, rows: count, notes };
}
