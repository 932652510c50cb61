import { Button, Switch } from "@mantine/core";
import { IconBell, IconBellRinging } from "@tabler/icons-react";
import { HeaderPopover } from "../../ui/buttons/HeaderPopover";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { Notices, type Leave } from "./notices";

const MEANING: Record<Leave, string> = {
  default: "The browser asks once whether this page may.",
  granted: "They come only while no one looks at this page.",
  denied: "The browser does not let this page: allow it beside the address, then switch it on here.",
  missing: "This browser shows none here: they need https, or localhost.",
};

/** Where the browser's notifications are switched on, and tried. */
export function NotifyButton() {
  const notices = useService(Notices);
  const wanted = useStore(notices.store, (state) => state.wanted);
  const leave = useStore(notices.store, (state) => state.leave);
  const on = wanted && leave === "granted";
  return (
    <HeaderPopover
      title="Notifications"
      state={on ? "on" : "off"}
      icon={on ? <IconBellRinging size={18} /> : <IconBell size={18} />}
      testId="notify"
    >
      {() => (
        <>
          <Switch
            label="Notify me of FAULT, E-STOP and the end of a run"
            checked={on}
            disabled={leave === "missing"}
            data-testid="notify-on"
            onChange={(event) => void notices.want(event.currentTarget.checked)}
          />
          <p className="note" data-testid="notify-state">
            {MEANING[leave]}
          </p>
          <Button
            size="xs"
            variant="default"
            w="fit-content"
            disabled={!on}
            data-testid="notify-test"
            onClick={() => notices.test()}
          >
            Show one now
          </Button>
        </>
      )}
    </HeaderPopover>
  );
}
