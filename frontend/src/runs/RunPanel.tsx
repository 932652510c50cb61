import { Progress } from "@mantine/core";
import { useDrawing } from "../drawing/drawing";
import { DrawPanel } from "../drawing/DrawPanel";
import { ReferencePanel } from "../drawing/library/ReferencePanel";
import { RunBar } from "./RunBar";
import type { RunState } from "../api/types";
import { usePage } from "../live/page";
import { Learned } from "./Learned";
import { errorText, lapText, STATE_WORD } from "./facts";
import { ResultCard } from "./ResultCard";
import { isUnderWay, useRuns } from "./runs";

/** What to follow, above; below, always in sight: what came of it or would, and the button that runs it. */
export function RunPanel() {
  const source = useDrawing((state) => state.source);
  return (
    <div className="run">
      <div className="panel run-subject">{source === "drawing" ? <DrawPanel /> : <ReferencePanel />}</div>
      <RunNews />
      <RunBar />
    </div>
  );
}

/** The run under way, else what came of the last one. */
function RunNews() {
  const run = usePage((page) => page.run);
  const result = usePage((page) => page.result);
  const dismissed = useRuns((choice) => choice.dismissed);
  return (
    <div className="run-news">
      {isUnderWay(run) ? (
        <>
          <UnderWay run={run} />
          <SoFar name={run.name} />
        </>
      ) : result && result.id !== dismissed ? (
        <ResultCard result={result} />
      ) : (
        <p className="note">No result yet: a run shows here how well it went.</p>
      )}
    </div>
  );
}

/** What the repeats before this one came to, while it is being learned. */
function SoFar({ name }: { readonly name: string }) {
  const learning = usePage(({ macro }) => macro?.state === "running" && macro.learning);
  const learned = usePage(({ result }) =>
    result?.name === name && result.learned?.learning ? result.learned : null,
  );
  return learning && learned ? <Learned learned={learned} /> : null;
}

function UnderWay({ run }: { readonly run: RunState }) {
  return (
    <section className="run-way" aria-label="Run under way" data-testid="run-progress" data-state={run.state}>
      <div className="run-way-line">
        <strong>{STATE_WORD[run.state]}</strong>
        <span className="run-name">{run.name}</span>
        <span className="number">{lapText(run)}</span>
        <span className="note run-name">{run.reason}</span>
        <span className="spacer" />
        <span className="number" data-testid="run-error">
          error {errorText(run.error)}
        </span>
        <span className="number run-rms">RMS {errorText(run.error_rms)}</span>
      </div>
      <Progress
        value={100 * run.progress}
        size="md"
        transitionDuration={150}
        aria-label="Progress of the run"
      />
    </section>
  );
}
