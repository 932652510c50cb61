import { useState } from "react";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { Commissioning } from "./commissioning";
import { StepCard } from "./StepCard";
import { nextStep, type StepName } from "./steps";
import { useCommissioningState, useRefresh } from "./useCommissioning";

const REFRESH_HZ = 4;

/** The step that someone opened, or none, and how many were accepted then: with one more the next opens by itself. */
interface Chosen {
  readonly step: StepName | null;
  readonly done: number;
}

/** The guided steps: each with what is done, what it lacks, and the way back. */
export function CommissioningPanel() {
  useRefresh(REFRESH_HZ);
  const state = useCommissioningState();
  const { store } = useService(Commissioning);
  const refusal = useStore(store, (seen) => seen.refusal);
  const [chosen, setChosen] = useState<Chosen | null>(null);
  if (state === null) return <p className="note">Asking the server.</p>;
  if (!state.available)
    return (
      <p className="note" role="alert" data-grade="bad">
        {state.reason}
      </p>
    );
  const done = state.steps.filter(({ accepted }) => accepted).length;
  const open = chosen?.done === done ? chosen.step : nextStep(state);
  return (
    <div className="column" data-testid="commissioning">
      <div className="row">
        <span className="note">
          {done} of {state.steps.length} steps accepted
        </span>
        <span className="spacer" />
        <a
          className="report-link"
          href="/api/commissioning/report"
          target="_blank"
          rel="noreferrer"
          data-testid="commissioning-report"
        >
          Report
        </a>
      </div>
      <ol className="steps">
        {state.steps.map((step) => (
          <StepCard
            key={step.name}
            step={step}
            state={state}
            open={open === step.name}
            refusal={open === step.name ? refusal : ""}
            toggle={() => setChosen({ step: open === step.name ? null : step.name, done })}
          />
        ))}
      </ol>
    </div>
  );
}
