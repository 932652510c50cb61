import { ActionIcon, Button, Tooltip } from "@mantine/core";
import { IconX } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import { api, dataOf } from "../api/rest";
import type { RunResult } from "../api/types";
import { PageStore, usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { Facts } from "../ui/Facts";
import { timeOfDay } from "../ui/format";
import { useService } from "../ui/services";
import { Learned } from "./Learned";
import { earlierOf, errorText, lapsDone, resultFacts, STATE_WORD } from "./facts";
import { Runs, useRuns } from "./runs";

/** What came of the last run, beside what was foreseen of it; and what to do with it. */
export function ResultCard({ result }: { readonly result: RunResult }) {
  const runs = useService(Runs);
  const foreseen = useRuns((choice) => (choice.foreseen?.run === result.id ? choice.foreseen.rmse : null));
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
        <Tooltip label="Close">
          <ActionIcon
            variant="subtle"
            color="gray"
            size="sm"
            aria-label="Close the result"
            onClick={() => runs.store.patch({ dismissed: result.id })}
          >
            <IconX size={15} />
          </ActionIcon>
        </Tooltip>
      </div>
      {result.rmse === null ? (
        <p className="note">{result.reason || "It ended before the path began."}</p>
      ) : (
        <div className="run-result-body">
          <Facts facts={resultFacts(result, foreseen)} testId="run-result-facts" />
          <Sparkline errors={result.errors} />
        </div>
      )}
      {result.learned ? <Learned learned={result.learned} /> : null}
      <div className="run-way-line run-result-actions">
        <FollowAgain />
        <OpenRecording id={result.recording} />
        <CompareEarlier result={result} />
      </div>
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
      waits
      onClick={() => void runs.again()}
    >
      Follow again
    </ControlButton>
  );
}

function OpenRecording({ id }: { readonly id: string | null }) {
  const page = useService(PageStore);
  if (id === null) return <span className="note">not recorded</span>;
  return (
    <Button
      size="compact-xs"
      variant="default"
      data-testid="run-recording"
      onClick={() => page.patch({ view: "review", reviewed: id, compared: [] })}
    >
      Open recording
    </Button>
  );
}

/** Beside the recording of the same thing that was run before. */
function CompareEarlier({ result }: { readonly result: RunResult }) {
  const page = useService(PageStore);
  const earlier = useEarlier(result);
  if (result.recording === null || earlier === null) return null;
  const compared = [earlier.recording, result.recording].filter((id) => id !== null);
  return (
    <Tooltip label={`Beside the run of ${timeOfDay(earlier.time)}`}>
      <Button
        size="compact-xs"
        variant="default"
        data-testid="run-compare"
        onClick={() => page.patch({ view: "review", reviewed: null, compared })}
      >
        Compare
      </Button>
    </Tooltip>
  );
}

/** The recorded run of the same name before `result`; null while it is not known, or without one. */
function useEarlier(result: RunResult): RunResult | null {
  const [found, setFound] = useState<RunResult | null>(null);
  useEffect(() => {
    let gone = false;
    const take = (results: readonly RunResult[]) => {
      if (!gone) setFound(earlierOf(result, results));
    };
    dataOf(api.GET("/api/runs")).then(take, () => {
      take([]);
    });
    return () => {
      gone = true;
    };
  }, [result]);
  return found;
}

const WIDTH = 160;
const HEIGHT = 30;

/** The error over a run [m], from 0 to its largest; where the tip was not seen the line is broken. */
function Sparkline({ errors }: { readonly errors: readonly (number | null)[] }) {
  const most = Math.max(...errors.map((error) => error ?? 0));
  if (errors.length < 2 || most <= 0) return null;
  return (
    <svg
      className="sparkline"
      viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
      preserveAspectRatio="none"
      role="img"
      aria-label={`Error over the run, at most ${errorText(most)}`}
      data-testid="run-sparkline"
    >
      <title>{`Error over the run: bottom 0, top ${errorText(most)}`}</title>
      <path d={linesOf(errors, most)} />
    </svg>
  );
}

function linesOf(errors: readonly (number | null)[], most: number): string {
  const step = WIDTH / (errors.length - 1);
  const point = (error: number, i: number) =>
    `${(i * step).toFixed(1)} ${((1 - error / most) * (HEIGHT - 2) + 1).toFixed(1)}`;
  return errors
    .map((error, i) =>
      error === null ? "" : `${i > 0 && errors[i - 1] !== null ? "L" : "M"}${point(error, i)}`,
    )
    .join("");
}
