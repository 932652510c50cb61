import { IconAlertTriangle, IconPlayerStopFilled, IconTool } from "@tabler/icons-react";
import { usePage } from "../../live/page";
import { ControlButton } from "../../operate/ControlButton";
import { useService } from "../../ui/services";
import { Commissioning } from "./commissioning";
import { useCommissioningState, useRefresh } from "./useCommissioning";

/** Behind other panels it is looked at so often. */
const REFRESH_HZ = 0.5;

/** To everyone: a step of the commissioning has the rig, and the way to stop it. */
export function CommissioningBar() {
  useRefresh(REFRESH_HZ);
  const commissioning = useService(Commissioning);
  const state = useCommissioningState();
  const running = state?.running ?? null;
  if (running === null) return null;
  const title = state?.steps.find(({ name }) => name === running.step)?.title ?? running.step;
  return (
    <div className="over-page" role="status" data-testid="commissioning-bar">
      <IconTool size={18} aria-hidden />
      <span>
        Commissioning, {title}: {running.doing}
      </span>
      <ControlButton
        control="settings"
        size="compact-sm"
        variant="default"
        leftSection={<IconPlayerStopFilled size={14} />}
        testId="commissioning-stop"
        meaning="End the step: the rig comes to rest and vents; any stop does so too"
        onClick={() => void commissioning.stop(running.step)}
      >
        Stop
      </ControlButton>
    </div>
  );
}

/** To everyone, for as long as it is so: the rig file lets the rig arm without what its commissioning finds. */
export function WaivedBar() {
  const waived = usePage((page) => page.rig?.parameters.hardware?.commissioned === "waived");
  if (!waived) return null;
  return (
    <div className="over-page over-page-bad" role="status" data-testid="arms-uncommissioned">
      <IconAlertTriangle size={18} aria-hidden />
      <span>Arms without commissioning (arm_uncommissioned in the rig file)</span>
    </div>
  );
}

/** What the rig lacks until it is commissioned; nothing once it is. */
export function Lacking({ text }: { readonly text: string }) {
  if (text === "") return null;
  return (
    <p className="lacking" data-testid="not-commissioned">
      <span aria-hidden data-grade="warning">
        ▲
      </span>{" "}
      {text}
    </p>
  );
}
