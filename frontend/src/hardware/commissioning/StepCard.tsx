import { Progress } from "@mantine/core";
import { useId, useState } from "react";
import { usePage } from "../../live/page";
import { ControlButton } from "../../operate/ControlButton";
import { localTime } from "../../ui/format";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { Commissioning } from "./commissioning";
import { Findings } from "./Findings";
import { FrameStep } from "./FrameStep";
import { JogStep } from "./JogStep";
import { StepInputs } from "./StepInputs";
import { bodyOf, MOVES, standingOf, type CommissioningState, type StepView, type TypedInputs } from "./steps";

interface Props {
  readonly step: StepView;
  readonly state: CommissioningState;
  readonly open: boolean;
  /** Why the last request was not done. */
  readonly refusal: string;
  readonly toggle: () => void;
}

/** One step: a line that says how it stands, and below it all that can be done about it. */
export function StepCard({ step, state, open, refusal, toggle }: Props) {
  const id = useId();
  const { word, mark, grade } = standingOf(step);
  return (
    <li
      className="step"
      data-testid={`step-${step.name}`}
      data-state={step.state}
      data-accepted={step.accepted}
    >
      <h3>
        <button type="button" className="step-head" aria-expanded={open} aria-controls={id} onClick={toggle}>
          <span className="step-title">{step.title}</span>
          <span className="step-lacks note">{step.lacks}</span>
          <span className="grade" data-grade={grade} data-testid={`step-word-${step.name}`}>
            <span aria-hidden>{mark}</span> {word}
          </span>
        </button>
      </h3>
      <div id={id} className="column step-body" hidden={!open}>
        {open ? <StepBody step={step} state={state} refusal={refusal} /> : null}
      </div>
    </li>
  );
}

function StepBody({ step, state, refusal }: Omit<Props, "open" | "toggle">) {
  const [typed, setTyped] = useState<TypedInputs>({});
  const running = state.running?.step === step.name;
  return (
    <>
      <p className="step-purpose">{step.purpose}</p>
      {step.withdrawn === "" ? null : (
        <p data-grade="bad" data-testid={`step-withdrawn-${step.name}`}>
          Accepted once, and withdrawn: {step.withdrawn}
        </p>
      )}
      {running || MOVES[step.name] === "" ? null : <p className="note">{MOVES[step.name]}</p>}
      {running ? (
        <Running state={state} step={step} />
      ) : (
        <>
          <Needs needs={step.needs} />
          <StepInputs step={step.name} typed={typed} type={setTyped} />
          <Result step={step} />
        </>
      )}
      <p className="step-refusal" role="alert" data-grade="bad" data-testid={`step-refusal-${step.name}`}>
        {refusal}
      </p>
      <Buttons step={step} running={running} busy={state.running !== null} typed={typed} />
    </>
  );
}

/** What is missing to begin. */
function Needs({ needs }: Pick<StepView, "needs">) {
  if (needs.length === 0) return null;
  return (
    <ul className="step-needs" aria-label="What is missing to begin">
      {needs.map((need) => (
        <li key={need}>{need}</li>
      ))}
    </ul>
  );
}

function Running({ state, step }: { readonly state: CommissioningState; readonly step: StepView }) {
  const { running } = state;
  if (running === null) return null;
  const share = 100 * running.share;
  return (
    <>
      <div className="step-progress">
        <p className="note" role="status">
          {capitalised(running.doing)}, started by {running.by}
        </p>
        <Progress value={share} size="sm" aria-label={`${step.title}, share done`} />
      </div>
      {step.name === "jog" ? <JogStep jog={state.jog} /> : null}
      {step.name === "frame" ? <FrameStep captured={state.captured} /> : null}
    </>
  );
}

function capitalised(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

function Result({ step }: { readonly step: StepView }) {
  if (step.result === "") return null;
  return (
    <div className="step-result" data-testid={`step-result-${step.name}`}>
      <p data-grade={step.state === "failed" ? "bad" : "good"}>{step.result}</p>
      <Findings numbers={step.numbers} writes={step.writes} accepted={step.accepted} />
      {step.at === null ? null : (
        <p className="note">
          {step.by}, {localTime(step.at)}
        </p>
      )}
    </div>
  );
}

interface ButtonsProps {
  readonly step: StepView;
  readonly running: boolean;
  /** Some step is under way. */
  readonly busy: boolean;
  readonly typed: TypedInputs;
}

/** Start or Stop, Accept, Back. */
function Buttons({ step, running, busy, typed }: ButtonsProps) {
  const commissioning = useService(Commissioning);
  const asking = useStore(commissioning.store, (seen) => seen.asking);
  const starting = usePage((page) => page.starting);
  const because = asking !== "" ? "The server is at it" : starting !== "" ? "The rig is starting" : null;
  const { name, state, accepted, needs } = step;
  if (running)
    return (
      <div className="row">
        <ControlButton
          control="settings"
          because={asking === `stop ${name}` ? "It is being stopped" : null}
          color="red"
          testId={`step-stop-${name}`}
          meaning="End it: the rig comes to rest and vents; any stop does so too"
          onClick={() => void commissioning.stop(name)}
        >
          Stop
        </ControlButton>
      </div>
    );
  const done = state === "done" && !accepted;
  const untouched = state === "todo" && !accepted;
  return (
    <div className="row">
      <ControlButton
        control="settings"
        because={because ?? (needs.length > 0 ? needs.join("; ") : null)}
        variant={state === "todo" || state === "failed" ? "filled" : "default"}
        loading={asking === `start ${name}`}
        testId={`step-start-${name}`}
        meaning={MOVES[name] === "" ? "Begin this step; nothing moves" : MOVES[name]}
        onClick={() => void commissioning.start(name, bodyOf(name, typed))}
      >
        {state === "todo" ? "Start" : "Again"}
      </ControlButton>
      <ControlButton
        control="settings"
        because={because ?? (busy ? "A step is under way" : done ? null : notAcceptable(step))}
        variant={done ? "filled" : "default"}
        loading={asking === `accept ${name}`}
        testId={`step-accept-${name}`}
        meaning={
          step.writes.length === 0
            ? "Note it in the rig file"
            : "Write it into the rig file; the rig may start again with it"
        }
        onClick={() => void commissioning.accept(name)}
      >
        Accept
      </ControlButton>
      <ControlButton
        control="settings"
        because={
          because ?? (busy ? "A step is under way" : untouched ? "There is nothing to take back" : null)
        }
        variant="default"
        loading={asking === `back ${name}`}
        testId={`step-back-${name}`}
        meaning="Forget what this step came to, and the steps that rest on it"
        onClick={() => void commissioning.back(name)}
      >
        Back
      </ControlButton>
    </div>
  );
}

function notAcceptable({ state, accepted }: StepView): string {
  if (accepted) return "It is accepted";
  return state === "failed" ? "It has no result that could be accepted" : "It has no result yet";
}
