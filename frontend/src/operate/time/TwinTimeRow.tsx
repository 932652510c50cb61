import { SegmentedControl } from "@mantine/core";
import { PageStore, usePage } from "../../live/page";
import { rounded } from "../../ui/format";
import { useService } from "../../ui/services";
import { ControlButton } from "../ControlButton";
import { isPaused } from "../permission";
import { STEP_LENGTHS, TwinTime } from "./twinTime";

/** Pause, continue and step; nothing where the rig is hardware. */
export function TwinTimeRow() {
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
        onChange={(value) => {
          page.patch({ step: Number(value) });
        }}
      />
    </div>
  );
}
