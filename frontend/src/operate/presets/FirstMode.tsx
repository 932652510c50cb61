import { IconPlayerStopFilled, IconWaveSine } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import { usePage } from "../../live/page";
import { ControlButton } from "../ControlButton";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { MODE } from "../../live/modes";
import { Facts } from "../../ui/Facts";
import { millimetres, plain } from "../../ui/format";
import { useService } from "../../ui/services";
import {
  firstMode,
  kappaToOffer,
  modeFacts,
  progressText,
  REPEATS,
  TRAVEL,
  type FirstModeInForce,
} from "./firstMode";
import { AskActuator } from "./AskActuator";
import { presets } from "./presets";
import { useWhyNoRestart } from "./useWhyNoRestart";

/** Damping ratio and kappa, on which the loop's margins rest: measured or assumed, and measured by a button. */
export function FirstMode() {
  const known = useKnown();
  const progress = usePage((page) => progressText(page.firstMode));
  return (
    <section className="first-mode" aria-label="First mode">
      <div className="row">
        <h3 className="bar-title">Margins rest on</h3>
        <Measure />
      </div>
      <p className="note" role="status" data-testid="first-mode-status">
        {progress === "" ? MEANING : progress}
      </p>
      {known ? (
        <>
          <Facts facts={modeFacts(known)} testId="first-mode-facts" />
          <ObserverKappa known={known} />
        </>
      ) : null}
    </section>
  );
}

/** What it will do, said before it does. */
const MEANING =
  `Measuring swings the arm in open loop, ${2 * REPEATS} steps to either side of straight: the tip moves by some ` +
  `${millimetres(TRAVEL, 0)} each time, for half a minute. Any stop ends it.`;

function useKnown(): FirstModeInForce | null {
  const operations = useService(Operations);
  const [known, setKnown] = useState<FirstModeInForce | null>(null);
  const boot = usePage((page) => page.rig?.boot);
  const online = usePage((page) => page.online);
  const running = usePage((page) => page.firstMode?.state === "running");
  useEffect(() => {
    if (!online || boot === undefined || running) return;
    void operations.attempt("First mode not known", async () => {
      setKnown(await firstMode.read());
    });
  }, [operations, online, boot, running]);
  return known;
}

/** Why it cannot begin now, null where it can. */
function useWhyNotNow(): string | null {
  const moved = useWhyNot("follow");
  const held = usePage((page) => page.mode === MODE.HOLD || page.mode === MODE.FOLLOW);
  const running = usePage((page) => page.firstMode?.state === "running");
  if (running) return "It is being measured";
  return held ? null : (moved ?? "Hold first");
}

function Measure() {
  const operations = useService(Operations);
  const because = useWhyNotNow();
  return (
    <ControlButton
      control="settings"
      because={because}
      variant="default"
      leftSection={<IconWaveSine size={15} />}
      testId="first-mode-measure"
      meaning="Measure damping ratio and stiffness factor by small steps"
      onClick={() => void operations.attempt("Not measured", firstMode.measure)}
    >
      Measure
    </ControlButton>
  );
}

/** Lets the observer's body move as fast as the arm was measured to, or by its table again; asks first. */
function ObserverKappa({ known }: { readonly known: FirstModeInForce }) {
  const operations = useService(Operations);
  const because = useWhyNoRestart();
  const [asked, setAsked] = useState(false);
  const kappa = kappaToOffer(known);
  if (kappa === null) return null;
  const word = kappa === 1 ? "the table's inertia" : `κ ${plain(kappa, 1)}`;
  return (
    <div className="row">
      <ControlButton
        control="settings"
        because={because}
        variant="default"
        testId="observer-kappa"
        meaning={`Start the rig again with ${word} in its observer`}
        onClick={() => setAsked(true)}
      >
        {kappa === 1 ? "Table's κ in the observer" : "Measured κ in the observer"}
      </ControlButton>
      <AskActuator
        wanted={asked ? `${word} in its observer` : null}
        onClose={() => setAsked(false)}
        onYes={() => {
          setAsked(false);
          void operations.attempt("Observer not changed", () => presets.observerKappa(kappa));
        }}
      />
    </div>
  );
}

/** To everyone: the arm swings because its first mode is being measured, and the way to stop it. */
export function FirstModeBar() {
  const operations = useService(Operations);
  const doing = usePage(({ firstMode: state }) => (state?.state === "running" ? state.doing : ""));
  if (doing === "") return null;
  return (
    <div className="over-page" role="status" data-testid="first-mode-bar">
      <IconWaveSine size={18} aria-hidden />
      <span>First mode: {doing}</span>
      <ControlButton
        control="settings"
        size="compact-sm"
        variant="default"
        leftSection={<IconPlayerStopFilled size={14} />}
        testId="first-mode-stop"
        meaning="End the measurement, and hold; any stop does so too"
        onClick={() => void operations.attempt("Not stopped", firstMode.stop)}
      >
        Stop
      </ControlButton>
    </div>
  );
}
