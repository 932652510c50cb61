import { IconPlayerStopFilled, IconPlaylist } from "@tabler/icons-react";
import { usePage } from "../../live/page";
import { ControlButton } from "../../operate/ControlButton";
import { useService } from "../../ui/services";
import { Macros, stepText } from "./macros";

/** To everyone: the macro that runs, its step, and the way to stop it. */
export function MacroBar() {
  const macros = useService(Macros);
  const macro = usePage((page) => page.macro);
  if (macro?.state !== "running") return null;
  return (
    <div className="over-page macro-bar" role="status" data-testid="macro-bar">
      <IconPlaylist size={18} aria-hidden />
      <span>
        Macro {macro.name}: {stepText(macro)}
      </span>
      <ControlButton
        control="settings"
        size="compact-sm"
        variant="default"
        testId="macro-stop"
        meaning="End the macro, and hold what it has set in motion; any stop does so too"
        leftSection={<IconPlayerStopFilled size={14} />}
        onClick={() => void macros.stop()}
      >
        Stop
      </ControlButton>
    </div>
  );
}
