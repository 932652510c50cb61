import { Button, NumberInput, Progress } from "@mantine/core";
import {
  IconInfinity,
  IconPlayerPause,
  IconPlayerPlay,
  IconPlayerRecordFilled,
  IconPlayerStop,
} from "@tabler/icons-react";
import { useDrawing } from "../drawing/drawing";
import { chosenInfo } from "../drawing/library/references";
import { usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { useService } from "../ui/services";
import { typedNumber, useTyped } from "../ui/numbers/typed";
import { ToolButton } from "../ui/buttons/ToolButton";
import { previewText } from "./facts";
import { isUnderWay, REPEATS, Runs, useRuns, whyNotLearned, whyNotRun } from "./runs";

/** Preview, and run or steer the run. */
export function RunBar() {
  const underWay = usePage((page) => isUnderWay(page.run));
  return (
    <div className="run-bar">
      <PreviewButton />
      <span className="spacer" />
      {underWay ? <Steering /> : <Start />}
    </div>
  );
}

/** Why the chosen subject cannot be followed, null if it can. */
function useReason(): string | null {
  const drawing = useDrawing((state) => state);
  const chosen = usePage(chosenInfo);
  return whyNotRun(drawing, chosen);
}

function PreviewButton() {
  const runs = useService(Runs);
  const reason = useReason();
  const previewing = useRuns((choice) => choice.previewing);
  if (previewing !== null && previewing > 0) return <Foreseeing share={previewing} />;
  return (
    <>
      <Button
        size="xs"
        variant="default"
        loading={previewing !== null}
        data-disabled={reason !== null}
        aria-disabled={reason !== null}
        title={reason ?? "Let the twin run it at once, from rest"}
        data-testid="preview"
        onClick={() => {
          if (reason === null) void runs.preview();
        }}
      >
        Preview
      </Button>
      <Prediction />
    </>
  );
}

/** A long one comes bit by bit. */
function Foreseeing({ share }: { readonly share: number }) {
  const runs = useService(Runs);
  return (
    <>
      <Button
        size="xs"
        variant="default"
        title="Foresee no more of it"
        data-testid="cancel-preview"
        onClick={() => runs.cancelPreview()}
      >
        Cancel
      </Button>
      <span className="run-prediction number">
        <span>{Math.floor(100 * share)} % foreseen</span>
        <Progress size="xs" value={100 * share} aria-label="Foreseen" data-testid="preview-progress" />
      </span>
    </>
  );
}

function Prediction() {
  const preview = useRuns((choice) => choice.preview);
  return (
    <span className="run-prediction number" role="status" data-testid="prediction">
      {preview ? previewText(preview).map((line) => <span key={line}>{line}</span>) : null}
    </span>
  );
}

function Start() {
  const runs = useService(Runs);
  const reason = useReason();
  const endless = useRuns((choice) => choice.endless);
  const record = useRuns((choice) => choice.record);
  return (
    <>
      <Laps />
      <ToolButton
        label="Until stopped"
        testId="endless"
        pressed={endless}
        onClick={() => runs.store.patch({ endless: !endless })}
      >
        <IconInfinity size={18} />
      </ToolButton>
      <ToolButton
        label="Record each run"
        testId="record-runs"
        pressed={record}
        onClick={() => runs.store.patch({ record: !record })}
      >
        <IconPlayerRecordFilled size={16} color={record ? "var(--stop)" : "currentColor"} />
      </ToolButton>
      <Learn reason={reason} />
      <ControlButton
        control="run"
        because={reason}
        variant="default"
        leftSection={<IconPlayerPlay size={15} />}
        testId="run"
        data-focus-home
        meaning="Go to the beginning, then follow it"
        waits
        onClick={() => void runs.run()}
      >
        Run
      </ControlButton>
    </>
  );
}

function Learn({ reason }: { readonly reason: string | null }) {
  const runs = useService(Runs);
  const endless = useRuns((choice) => choice.endless);
  const controller = usePage(({ rig, settings }) => rig?.controllers[settings?.controller ?? 0]);
  return (
    <ControlButton
      control="run"
      because={reason ?? whyNotLearned(controller, endless)}
      variant="default"
      testId="learn"
      meaning={`Follow it ${REPEATS} times, each time with what the error of the ones before taught`}
      waits
      onClick={() => void runs.learn()}
    >
      Learn
    </ControlButton>
  );
}

/** A whole number; a field that is left empty shows again what is in force. */
function Laps() {
  const runs = useService(Runs);
  const endless = useRuns((choice) => choice.endless);
  const laps = useRuns((choice) => choice.laps);
  const { typed, setTyped, drop } = useTyped();
  return (
    <NumberInput
      size="xs"
      w={62}
      className="number-field"
      aria-label="Laps"
      data-testid="laps"
      min={1}
      max={1000}
      allowDecimal={false}
      clampBehavior="strict"
      disabled={endless}
      value={typed ?? laps}
      suffix=" ×"
      onChange={(now) => {
        setTyped(now);
        const wanted = typedNumber(now);
        if (wanted !== null && wanted >= 1) runs.repeat(wanted);
      }}
      onBlur={() => drop()}
    />
  );
}

function Steering() {
  const runs = useService(Runs);
  const paused = usePage((page) => page.run?.state === "paused");
  return (
    <>
      {paused ? (
        <ControlButton
          control="run"
          variant="default"
          leftSection={<IconPlayerPlay size={15} />}
          testId="resume-run"
          data-focus-home
          meaning="Go back to where it was, then on"
          waits
          onClick={() => void runs.steer("resume")}
        >
          Resume
        </ControlButton>
      ) : (
        <ControlButton
          control="hold"
          variant="default"
          leftSection={<IconPlayerPause size={15} />}
          testId="pause-run"
          data-focus-home
          meaning="Hold here; it can go on later"
          onClick={() => void runs.steer("pause")}
        >
          Pause
        </ControlButton>
      )}
      <ControlButton
        control="settings"
        variant="default"
        leftSection={<IconPlayerStop size={15} />}
        testId="stop-run"
        meaning="Hold here and end the run"
        onClick={() => void runs.steer("stop")}
      >
        Stop
      </ControlButton>
    </>
  );
}
