import { SegmentedControl, Switch, TextInput, Tooltip } from "@mantine/core";
import type { CommandBody, Settings } from "../api/types";
import { operatorText, PageStore, silenceOf, usePage, type Page } from "../live/page";
import { CAUSE_TEXT, isLatched, isSwing, MODE, MODE_WORD, remedy } from "../live/modes";
import { rounded } from "../ui/format";
import { useService } from "../ui/services";
import { ControlButton } from "./ControlButton";
import { Operations } from "./operations";
import { isPaused, useWhyNot, type Control } from "./permission";
import { SettingField } from "./SettingField";
import { limits, SCALARS } from "./settings";
import { TargetControl } from "./target/targetControl";
import { STEP_LENGTHS, TwinTime } from "./time/twinTime";

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
function advice(page: Page): string {
  const { lease, me, mode, cause } = page;
  const silent = silenceOf(page);
  if (silent !== "none" || mode === null) return `Waiting for the ${silent === "server" ? "server" : "rig"}.`;
  if (!lease.mine)
    return lease.held
      ? `${operatorText(page)}. You can watch, and stop.`
      : me.role === "viewer"
        ? "You can watch, and stop. The operator can hand control over to you."
        : "Take control to operate (beside the state, at the top).";
  if (isPaused(page)) return `The twin is paused in ${MODE_WORD[mode]}. Continue, or take single steps.`;
  if (isLatched(mode)) return `Latched. ${remedy(cause)}, then clear.`;
  if (isSwing(cause) && mode === MODE.VENTED) return `${remedy(cause)}, then arm again.`;
  if (isSwing(cause) && mode === MODE.REST)
    return `Returning to rest: ${CAUSE_TEXT[cause]}. ${remedy(cause)} before you arm again.`;
  if (mode === MODE.VENTED) return "Arm to pressurise the actuator.";
  if (mode === MODE.REST) return "Returning to rest, then vented.";
  if (lease.clutch) return "Held clutch: hold the target, an arrow key or the gamepad's A; letting go holds.";
  if (mode === MODE.HOLD) return "Armed. Drag the target in the plan, or press Follow.";
  return "Following. Drag the target, or move it with the arrow keys.";
}

/** Arm, follow, hold, disarm, clear; how a target is followed; the name of the next recording. */
export function ControlPanel() {
  const targetControl = useService(TargetControl);
  const operations = useService(Operations);
  const page = useService(PageStore);
  const text = usePage(advice);
  const name = usePage((page) => page.recordingName);
  const run = (request: CommandBody["request"]) => {
    void (request === "follow" ? targetControl.follow() : operations.command({ request }));
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
            variant="default"
            testId={control}
            meaning={meaning}
            onClick={() => run(request)}
          >
            {label}
          </ControlButton>
        ))}
      </div>
      <FollowLimits />
      <FollowHand />
      <TwinTimeRow />
      <TextInput
        size="xs"
        maw={320}
        label="Name of the next recording"
        placeholder="optional"
        maxLength={80}
        data-testid="recording-name"
        value={name}
        onChange={(event) => page.patch({ recordingName: event.currentTarget.value })}
      />
    </div>
  );
}

/** How fast a live target may be followed. */
function FollowLimits() {
  const settings = usePage((page) => page.settings);
  if (!settings) return null;
  return (
    <div className="row" role="group" aria-label="Limits of a live target">
      <Limit settings={settings} name="speed_max" title="Speed limit" />
      <Limit settings={settings} name="acceleration_max" title="Acceleration limit" />
    </div>
  );
}

interface LimitProps {
  readonly settings: Settings;
  readonly name: "speed_max" | "acceleration_max";
  readonly title: string;
}

function Limit({ settings, name, title }: LimitProps) {
  const shown = SCALARS.find((scalar) => scalar.name === name);
  if (!shown) return null;
  const { meaning, unit, scale, step } = shown;
  return (
    <span className="limit">
      <span className="note">{title}</span>
      <SettingField
        label={meaning}
        testId={`limit-${name}`}
        value={rounded(settings[name] * scale)}
        step={step}
        unit={unit}
        {...limits(shown)}
        change={(wanted) => ({ [name]: wanted / scale })}
      />
      <span className="unit">{unit}</span>
    </span>
  );
}

/** Held clutch, and the gamepad that is heard. */
function FollowHand() {
  const targetControl = useService(TargetControl);
  const clutch = usePage((page) => page.lease.clutch);
  const gamepad = usePage((page) => page.gamepad);
  const reason = useWhyNot("settings");
  return (
    <div className="row">
      <Tooltip label={reason ?? "The target moves only while it is held; letting go holds the rig"}>
        <Switch
          size="sm"
          label="Held clutch"
          data-testid="clutch"
          checked={clutch}
          disabled={reason !== null}
          onChange={(event) => void targetControl.setClutch(event.currentTarget.checked)}
        />
      </Tooltip>
      <span className="note" data-testid="gamepad">
        {gamepad === ""
          ? "No gamepad: press a button on one to connect it"
          : `${gamepad}: hold A and steer with the left stick; B holds`}
      </span>
    </div>
  );
}

/** Pause, continue and step; nothing where the rig is hardware. */
function TwinTimeRow() {
  const [page, time] = [useService(PageStore), useService(TwinTime)];
  const twin = usePage((state) => state.rig?.twin === true);
  const paused = usePage(isPaused);
  const step = usePage((state) => state.step);
  const dt = usePage((state) => state.rig?.parameters.controller.dt ?? 0);
  if (!twin) return null;
  return (
    <div className="row" role="group" aria-label="The twin's time">
      <ControlButton
        control="time"
        variant="default"
        testId="twin-pause"
        meaning="The whole loop stands still between two ticks: arm, observer and controller (P)"
        onClick={() => void time.toggle()}
      >
        {paused ? "Continue" : "Pause twin"}
      </ControlButton>
      <ControlButton
        control="time"
        because={paused ? null : "Pause the twin first"}
        variant="default"
        testId="twin-step"
        meaning="Go on for as long, and stand still again (.)"
        onClick={() => void time.step()}
      >
        Step
      </ControlButton>
      <SegmentedControl
        size="xs"
        aria-label="Length of a step"
        data-testid="twin-step-length"
        value={String(step)}
        data={STEP_LENGTHS.map((ticks) => ({
          value: String(ticks),
          label: `${rounded(ticks * dt * 1e3)} ms`,
        }))}
        onChange={(value) => page.patch({ step: Number(value) })}
      />
    </div>
  );
}
