import {
  ActionIcon,
  Button,
  SegmentedControl,
  Tooltip,
  useComputedColorScheme,
  useMantineColorScheme,
} from "@mantine/core";
import { IconHandStop, IconKeyboard, IconMoon, IconSun, IconUser } from "@tabler/icons-react";
import { ControlButton } from "./ControlButton";
import { RecordButton } from "./RecordButton";
import { StatePill } from "./StatePill";
import { useDashboard, usePage } from "./context";

export type View = "live" | "review";

interface Props {
  readonly view: View;
  readonly onView: (view: View) => void;
  readonly onHelp: () => void;
}

export function Header({ view, onView, onHelp }: Props) {
  return (
    <header className="header">
      <h1 className="brand">Tendril</h1>
      <RigName />
      <SegmentedControl
        size="xs"
        aria-label="View"
        value={view}
        onChange={(value) => {
          onView(value === "review" ? "review" : "live");
        }}
        data={[
          { value: "live", label: "Live" },
          { value: "review", label: "Review" },
        ]}
      />
      <StatePill />
      <span className="spacer" />
      <LeaseControl />
      <RecordButton />
      <SchemeButton />
      <Tooltip label="Keys (?)">
        <ActionIcon variant="subtle" color="gray" aria-label="Keys" onClick={onHelp}>
          <IconKeyboard size={18} />
        </ActionIcon>
      </Tooltip>
      <EStop />
    </header>
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
        {rig.twin ? " · twin" : ""}
      </span>
    </Tooltip>
  );
}

/** Who operates, and the way to take it over or give it back. */
function LeaseControl() {
  const dashboard = useDashboard();
  const lease = usePage((page) => page.lease);
  return (
    <span className="lease" data-testid="lease" data-mine={lease.mine} data-held={lease.held}>
      <IconUser size={15} aria-hidden />
      <span className="lease-holder">
        {lease.mine ? "you operate" : lease.held ? lease.holder : "no operator"}
      </span>
      {lease.mine ? (
        <ControlButton
          control="release"
          variant="default"
          testId="lease-release"
          meaning="Give control back; a motion is held"
          onClick={() => void dashboard.operations.releaseLease()}
        >
          Release
        </ControlButton>
      ) : (
        <ControlButton
          control="take"
          variant="filled"
          testId="lease-take"
          meaning="Become the operator: only one page at a time can move the rig"
          onClick={() => void dashboard.operations.takeLease()}
        >
          Take control
        </ControlButton>
      )}
    </span>
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
        onClick={() => {
          setColorScheme(dark ? "light" : "dark");
        }}
      >
        {dark ? <IconSun size={18} /> : <IconMoon size={18} />}
      </ActionIcon>
    </Tooltip>
  );
}

/** Works for every signed-in viewer, in every state; it is never disabled. */
function EStop() {
  const dashboard = useDashboard();
  const reaches = usePage((page) => page.online && page.rigLive);
  const meaning = reaches
    ? "Vent at once (Esc Esc)"
    : "The rig does not answer: use the hardware stop as well";
  return (
    <Tooltip label={meaning}>
      <Button
        className="e-stop"
        color="red"
        size="md"
        data-testid="e-stop"
        aria-label={`E-STOP. ${meaning}`}
        leftSection={<IconHandStop size={20} aria-hidden />}
        onClick={() => void dashboard.operations.emergencyStop()}
      >
        E-STOP
      </Button>
    </Tooltip>
  );
}
