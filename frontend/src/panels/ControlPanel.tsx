import { TextInput } from "@mantine/core";
import type { CommandBody } from "../api/types";
import { isLatched, MODE } from "../state/modes";
import type { Page } from "../state/page";
import type { Control } from "../state/permission";
import { ControlButton } from "./ControlButton";
import { useDashboard, usePage } from "./context";

interface Step {
  readonly control: Control;
  readonly request: CommandBody["request"];
  readonly label: string;
  readonly meaning: string;
}

const STEPS: readonly Step[] = [
  { control: "arm", request: "arm", label: "Arm", meaning: "Pressurise: from VENTED to HOLD" },
  { control: "follow", request: "follow", label: "Follow", meaning: "Follow the target where it stands (F)" },
  { control: "hold", request: "hold", label: "Hold", meaning: "Freeze the reference where it is (Esc)" },
  {
    control: "disarm",
    request: "rest",
    label: "Disarm",
    meaning: "Return to rest at a bounded rate, then vent",
  },
  { control: "clear", request: "clear", label: "Clear", meaning: "Unlatch FAULT or E-STOP; then VENTED" },
];

/** What to do next, in one sentence. */
function advice({ online, rigLive, lease, mode }: Page): string {
  if (!online || !rigLive || mode === null) return "Waiting for the rig.";
  if (!lease.mine)
    return lease.held
      ? `${lease.holder} operates. You can watch, and stop.`
      : "Take control to operate (top right).";
  if (isLatched(mode)) return "Latched. Find out why, then clear.";
  if (mode === MODE.VENTED) return "Arm to pressurise the actuator.";
  if (mode === MODE.REST) return "Returning to rest, then vented.";
  if (mode === MODE.HOLD) return "Armed. Drag the target in the plan, or press Follow.";
  return "Following. Drag the target, or move it with the arrow keys.";
}

/** The control that leads on from here: the only filled button. */
function nextControl({ lease, mode }: Page): Control | null {
  if (!lease.mine || mode === null) return null;
  if (isLatched(mode)) return "clear";
  if (mode === MODE.VENTED) return "arm";
  return mode === MODE.HOLD ? "follow" : null;
}

/** Arm, follow, hold, disarm, clear; and the name of the next recording. */
export function ControlPanel() {
  const dashboard = useDashboard();
  const text = usePage(advice);
  const next = usePage(nextControl);
  const name = usePage((page) => page.recordingName);
  const run = (request: CommandBody["request"]) => {
    void (request === "follow" ? dashboard.aim.follow() : dashboard.operations.command({ request }));
  };
  return (
    <div className="panel">
      <p className="advice" role="status">
        {text}
      </p>
      <div className="row">
        {STEPS.map(({ control, request, label, meaning }) => (
          <ControlButton
            key={control}
            control={control}
            size="sm"
            variant={next === control ? "filled" : "default"}
            testId={control}
            meaning={meaning}
            onClick={() => {
              run(request);
            }}
          >
            {label}
          </ControlButton>
        ))}
      </div>
      <TextInput
        size="xs"
        maw={320}
        label="Name of the next recording"
        placeholder="optional"
        maxLength={80}
        data-testid="recording-name"
        value={name}
        onChange={(event) => {
          dashboard.page.patch({ recordingName: event.currentTarget.value });
        }}
      />
    </div>
  );
}
