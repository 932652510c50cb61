import type { ReactNode } from "react";
import { usePage, type Page } from "../live/page";
import { clearing, isLatched, MODE } from "../live/modes";
import { useService } from "../ui/services";
import { ControlButton } from "./ControlButton";
import { Operations } from "./operations";
import { isPaused, type Control } from "./permission";
import { TargetControl } from "./target/targetControl";
import { TwinTime } from "./time/twinTime";

/** The actions that lead on, one for each state. */
export type Primary = Extract<Control, "take" | "clear" | "arm" | "follow" | "hold" | "time">;

/** What leads on from here. */
export function primaryOf(page: Pick<Page, "lease" | "mode" | "online" | "rigLive" | "health">): Primary {
  const { lease, mode } = page;
  if (lease.mine && isPaused(page)) return "time";
  const latched = mode !== null && isLatched(mode);
  if (latched && lease.held) return "clear";
  if (!lease.mine) return "take";
  if (mode === MODE.HOLD) return "follow";
  return mode === MODE.FOLLOW || mode === MODE.TRACK ? "hold" : "arm";
}

/** What it does, to hover over. */
const MEANING: Record<Primary, string> = {
  take: "Become the operator: only one page at a time can move the rig",
  clear: "Unlatch: the rig is then VENTED and needs a new Arm",
  arm: "Pressurise: from VENTED to HOLD",
  follow: "Follow the target where it stands (F)",
  hold: "Freeze the reference where it is (Esc)",
  time: "Let the twin's time go on (P)",
};
const TEST_ID: Record<Primary, string> = {
  take: "lease-take",
  clear: "clear-latch",
  arm: "primary-arm",
  follow: "primary-follow",
  hold: "primary-hold",
  time: "primary-continue",
};

/** The one filled button of the page, always in the same place: take control, clear, arm, follow, hold. */
export function PrimaryAction() {
  const [operations, targetControl, time] = [
    useService(Operations),
    useService(TargetControl),
    useService(TwinTime),
  ];
  const primary = usePage(primaryOf);
  const words = usePage(({ mode }) => (mode !== null && isLatched(mode) ? clearing(mode) : "Clear"));
  const label: Record<Primary, ReactNode> = {
    take: "Take control",
    clear: words,
    arm: "Arm",
    follow: "Follow",
    hold: "Hold",
    time: "Continue",
  };
  const act: Record<Primary, () => Promise<unknown>> = {
    take: () => operations.takeLease(),
    clear: () => operations.command({ request: "clear" }),
    arm: () => operations.command({ request: "arm" }),
    follow: () => targetControl.follow(),
    hold: () => operations.command({ request: "hold" }),
    time: () => time.toggle(),
  };
  return (
    <ControlButton
      key={primary}
      control={primary}
      size="sm"
      variant="filled"
      className="primary"
      testId={TEST_ID[primary]}
      meaning={MEANING[primary]}
      replaces
      waits={primary !== "hold"}
      data-focus-home
      onClick={() => void act[primary]()}
    >
      {label[primary]}
    </ControlButton>
  );
}
