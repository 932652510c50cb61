import { useEffect, useId } from "react";
import { usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { Operations } from "../operate/operations";
import { useWhyNot } from "../operate/permission";
import { MODE } from "../live/modes";
import { useService } from "../ui/services";
import { useStore } from "../ui/store";
import type { Problem } from "./problem";
import { RigFileEditor, standing } from "./rigFile";

/** The file may also be changed by other pages, and by programs on the server [ms]. */
const REFRESH_MS = 3000;

/** The rig file in an editor; it is saved while the rig is vented, which starts the rig with it. */
export function RigFilePanel() {
  const editor = useLearned();
  const editing = useStore(editor.store, (state) => state);
  const { disk, draft, problem, saving, failure } = editing;
  const because = useWhyNotSaved();
  const heading = useId();
  if (disk === null) return <p className="note">Reading the rig file.</p>;
  const said = standing(editing);
  const changed = draft !== disk.text;
  return (
    <section className="column" aria-labelledby={heading}>
      <div className="row">
        <h3 className="bar-title" id={heading}>
          Rig file
        </h3>
        <span
          className="grade"
          role="status"
          data-grade={changed || !disk.in_force ? "warning" : "good"}
          data-testid="rig-file-standing"
        >
          {said}
        </span>
      </div>
      <p className="note rig-file-path">{disk.path}</p>
      <FileText draft={draft} line={problem?.line ?? null} type={editor.type.bind(editor)} />
      <Wrong problem={problem} />
      <div className="row">
        <ControlButton
          control="settings"
          because={because}
          loading={saving}
          testId="rig-file-save"
          meaning="Check it, write it, and start the rig with it"
          onClick={() => void editor.save()}
        >
          Save and start the rig
        </ControlButton>
        <ControlButton
          control="edit"
          because={changed ? null : "Nothing is changed"}
          variant="default"
          testId="rig-file-revert"
          meaning="What lies on the disk again"
          onClick={() => editor.revert()}
        >
          Revert
        </ControlButton>
      </div>
      <Why because={because} reason={disk.reason} failure={failure} />
    </section>
  );
}

function useLearned(): RigFileEditor {
  const [editor, operations] = [useService(RigFileEditor), useService(Operations)];
  const online = usePage((page) => page.online);
  const boot = usePage((page) => page.rig?.boot);
  useEffect(() => {
    if (!online) return;
    void operations.attempt("Rig file not known", () => editor.learn());
    const timer = setInterval(() => {
      if (document.visibilityState === "visible") editor.learn().catch(() => undefined); // the connection tells of it
    }, REFRESH_MS);
    return () => {
      clearInterval(timer);
    };
  }, [editor, operations, online, boot]);
  return editor;
}

/** Why it cannot be saved now, beside what forbids every setting; null where it can. */
function useWhyNotSaved(): string | null {
  const editor = useService(RigFileEditor);
  const { disk, draft, saving } = useStore(editor.store, (state) => state);
  const starting = usePage((page) => page.starting);
  const rigLive = usePage((page) => page.rigLive);
  const vented = usePage((page) => page.mode === MODE.VENTED);
  const recording = usePage((page) => page.recording.recording);
  if (disk === null) return "Reading the rig file";
  if (disk.reason !== "" && (disk.rig !== null || disk.path === "")) return disk.reason; // one that is wrong may be mended
  if (saving) return "The server checks that a rig of this file stands and moves";
  if (starting !== "") return "The rig is starting";
  if (draft === disk.text && disk.in_force) return "Nothing is changed";
  if (!rigLive) return "The rig does not answer";
  if (!vented) return "Disarm first: saving starts the rig again";
  return recording ? "A recording is being made: end it first" : null;
}

interface FileTextProps {
  readonly draft: string;
  /** The line that is wrong. */
  readonly line: number | null;
  readonly type: (draft: string) => void;
}

/** Text with the numbers of its lines. */
function FileText({ draft, line, type }: FileTextProps) {
  const lines = draft.split("\n").length;
  return (
    <div className="file-text">
      <ol className="file-lines" aria-hidden>
        {Array.from({ length: lines }, (_, i) => (
          <li key={i} data-wrong={line === i + 1}>
            {i + 1}
          </li>
        ))}
      </ol>
      <textarea
        className="file-area"
        aria-label="Rig file, TOML"
        data-testid="rig-file-text"
        wrap="off"
        spellCheck={false}
        autoCapitalize="off"
        autoComplete="off"
        rows={lines}
        value={draft}
        onChange={(event) => type(event.currentTarget.value)}
      />
    </div>
  );
}

/** What is wrong with it: field, value and bound. */
function Wrong({ problem }: { readonly problem: Problem | null }) {
  return (
    <div role="alert" className="file-problem" data-testid="rig-file-problem">
      {problem === null ? null : (
        <p data-grade="bad">
          {problem.line === null ? "" : `Line ${problem.line}: `}
          {problem.field === "" ? "" : <code>{`${problem.field} = ${problem.value}`}</code>} {problem.bound}
        </p>
      )}
    </div>
  );
}

interface WhyProps {
  readonly because: string | null;
  readonly reason: string;
  readonly failure: string;
}

function Why({ because, reason, failure }: WhyProps) {
  const forbidden = useWhyNot("settings");
  return (
    <>
      {reason === "" ? null : (
        <p className="note" role="alert" data-grade="bad">
          {reason}
        </p>
      )}
      {failure === "" ? null : (
        <p className="note" role="alert" data-grade="bad">
          {failure}
        </p>
      )}
      <p className="note" role="status" data-testid="rig-file-why">
        {forbidden ?? because ?? "Saving starts the rig again, vented."}
      </p>
    </>
  );
}
