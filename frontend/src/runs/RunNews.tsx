import { ActionIcon, Button, Progress, Tooltip } from "@mantine/core";
import { IconX } from "@tabler/icons-react";
import type { RunResult, RunState } from "../api/types";
import { PageStore, usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { Facts } from "../ui/Facts";
import { timeOfDay } from "../ui/format";
import { useService } from "../ui/services";
import { errorText, lapsDone, lapText, resultFacts, STATE_WORD } from "./facts";
import { isUnderWay, Runs, useRuns } from "./runs";

/** The run under way, else what came of the last one; always of the same height. */
export function RunNews() {
  const run = usePage((page) => page.run);
  const result = usePage((page) => page.result);
  const dismissed = useRuns((choice) => choice.dismissed);
  return (
    <div className="run-news">
      {isUnderWay(run) ? (
        <UnderWay run={run} />
      ) : result && result.id !== dismissed ? (
        <ResultCard result={result} />
      ) : (
        <p className="note">No result yet: a run shows here how well it went.</p>
      )}
    </div>
  );
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

function ResultCard({ result }: { readonly result: RunResult }) {
  const runs = useService(Runs);
  return (
    <section
      className="run-result"
      aria-label="Result of the last run"
      data-testid="run-result"
      data-state={result.state}
    >
      <div className="run-way-line">
        <strong>{STATE_WORD[result.state]}</strong>
        <span className="run-name">{result.name}</span>
        <span className="note number run-name" title={result.reason}>
          {[lapsDone(result), timeOfDay(result.time), result.reason].filter(Boolean).join(", ")}
        </span>
        <span className="spacer" />
        <FollowAgain />
        <RecordingLink id={result.recording} />
        <Tooltip label="Close">
          <ActionIcon
            variant="subtle"
            color="gray"
            size="sm"
            aria-label="Close the result"
            onClick={() => {
              runs.store.patch({ dismissed: result.id });
            }}
          >
            <IconX size={15} />
          </ActionIcon>
        </Tooltip>
      </div>
      {result.rmse === null ? (
        <p className="note">{result.reason || "It ended before the path began."}</p>
      ) : (
        <Facts facts={resultFacts(result)} testId="run-result-facts" />
      )}
    </section>
  );
}

/** The last run once more: from where it ended, without an approach where it begins there. */
function FollowAgain() {
  const runs = useService(Runs);
  const known = usePage((page) => page.run !== null);
  return (
    <ControlButton
      control="run"
      because={known ? null : "The server was started since: choose what to follow, and run it"}
      variant="default"
      size="compact-xs"
      testId="follow-last"
      meaning="The same once more, from where the tip is; no approach where it stands at the beginning"
      onClick={() => void runs.again()}
    >
      Follow again
    </ControlButton>
  );
}

function RecordingLink({ id }: { readonly id: string | null }) {
  const page = useService(PageStore);
  if (id === null) return <span className="note">not recorded</span>;
  return (
    <Button
      size="compact-xs"
      variant="subtle"
      data-testid="run-recording"
      onClick={() => {
        page.patch({ view: "review", reviewed: id, compared: [] });
      }}
    >
      Recording
    </Button>
  );
}
