import {
  ActionIcon,
  SegmentedControl,
  Tooltip,
  useComputedColorScheme,
  useMantineColorScheme,
} from "@mantine/core";
import { IconDeviceTv, IconKeyboard, IconLockOpen, IconMoon, IconSun } from "@tabler/icons-react";
import { memo } from "react";
import { Health } from "../health/Health";
import { PageStore, usePage } from "../live/page";
import { NotifyButton } from "../health/notify/NotifyButton";
import { LockButton } from "../operate/lock/LockButton";
import { LeaseControl } from "../operate/lease/LeaseControl";
import { PrimaryAction } from "../operate/PrimaryAction";
import { Cause } from "../operate/StatePill";
import { RecordButton } from "../recorder/RecordButton";
import { Part } from "../ui/Part";
import { useService } from "../ui/services";

/** Over all views, and not drawn again by a change of it. */
export const Header = memo(function Header() {
  const page = useService(PageStore);
  return (
    <header className="header">
      <h1 className="brand">Tendril</h1>
      <RigName />
      <Views />
      <Part name="Health">
        <Health />
      </Part>
      <span className="spacer" />
      <Cause />
      <Unprotected />
      <LeaseControl />
      <RecordButton />
      <LockButton />
      <WallButton />
      <NotifyButton />
      <SchemeButton />
      <Tooltip label="Keys (?)">
        <ActionIcon
          variant="subtle"
          color="gray"
          className="help"
          aria-label="Keys"
          onClick={() => page.patch({ help: true })}
        >
          <IconKeyboard size={18} />
        </ActionIcon>
      </Tooltip>
      <PrimaryAction />
    </header>
  );
});

function Views() {
  const page = useService(PageStore);
  const view = usePage((state) => state.view);
  return (
    <SegmentedControl
      size="xs"
      aria-label="View"
      value={view}
      onChange={(value) => page.patch({ view: value === "review" ? "review" : "live" })}
      data={[
        { value: "live", label: "Live" },
        { value: "review", label: "Review" },
      ]}
    />
  );
}

function RigName() {
  const rig = usePage((page) => page.rig);
  if (!rig) return null;
  const { name } = rig.parameters.actuator;
  return (
    <Tooltip
      label={`Rig ${rig.rig}, actuator ${name}, version ${rig.version}${rig.twin ? ", simulated" : ""}`}
    >
      <span className="rig-name">
        {rig.rig} · {name}
        {rig.twin ? ` · ${rig.parameters.twin.plant === "cosserat" ? "Cosserat twin" : "twin"}` : ""}
      </span>
    </Tooltip>
  );
}

const MEANING =
  "Other machines reach this server without TLS: who is in the network can read and change what is said, tokens included";

/** Marks a server that others can reach unencrypted. */
function Unprotected() {
  const unprotected = usePage((page) => page.me.unprotected);
  if (!unprotected) return null;
  return (
    <Tooltip label={MEANING} multiline maw={320}>
      <span className="unprotected" data-testid="unprotected" role="img" aria-label={MEANING}>
        <IconLockOpen size={15} aria-hidden /> no TLS
      </span>
    </Tooltip>
  );
}

/** Large numbers for who stands across the room. */
function WallButton() {
  const page = useService(PageStore);
  return (
    <Tooltip label="Large numbers, for a screen across the room">
      <ActionIcon
        variant="subtle"
        color="gray"
        aria-label="Large numbers"
        data-testid="wall-open"
        onClick={() => page.patch({ view: "wall" })}
      >
        <IconDeviceTv size={18} />
      </ActionIcon>
    </Tooltip>
  );
}

function SchemeButton() {
  const { setColorScheme } = useMantineColorScheme();
  const dark = useComputedColorScheme("dark", { getInitialValueInEffect: false }) === "dark";
  return (
    <Tooltip label={dark ? "Light colours" : "Dark colours"}>
      <ActionIcon
        variant="subtle"
        color="gray"
        aria-label={dark ? "Light colours" : "Dark colours"}
        onClick={() => setColorScheme(dark ? "light" : "dark")}
      >
        {dark ? <IconSun size={18} /> : <IconMoon size={18} />}
      </ActionIcon>
    </Tooltip>
  );
}
