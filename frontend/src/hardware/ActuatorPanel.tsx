import { FileButton, Loader } from "@mantine/core";
import { IconFileUpload } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import type { RigInfo } from "../api/types";
import { usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { Operations } from "../operate/operations";
import { Facts } from "../ui/Facts";
import { kilopascals, millimetres, plain, seconds } from "../ui/format";
import { LiveText } from "../ui/LiveText";
import { useService } from "../ui/services";
import { AskActuator } from "../operate/presets/AskActuator";
import { presets, type ActuatorChoice, type Plant, type Wanted } from "../operate/presets/presets";
import { Choices } from "./Choices";
import { SimulatedBy } from "./SimulatedBy";
import { useWhyNoRestart } from "../operate/presets/useWhyNoRestart";

type Actuator = RigInfo["parameters"]["actuator"];
const GRAM = 1e3;
/** Longest file that is read. */
const FILE_MAX = 400_000;

/** The rig's actuator, and others to start it with. */
export function ActuatorPanel() {
  const operations = useService(Operations);
  const rig = usePage((page) => page.rig);
  const online = usePage((page) => page.online);
  const starting = usePage((page) => page.starting);
  const boot = rig?.boot;
  const [choice, setChoice] = useState<ActuatorChoice | null>(null);
  const [asked, setAsked] = useState<Wanted | null>(null);
  const [checked, setChecked] = useState<string | null>(null);
  useEffect(() => {
    // Whether the rig is the server's own, and how it started with the last choice, is known by the server alone.
    if (!online) return;
    void operations.attempt("Actuators not known", async () => {
      setChoice(await presets.actuators());
    });
  }, [operations, online, boot, starting]);
  if (!rig) return <p className="panel note">Waiting for the rig.</p>;
  const change = async ({ name, body }: Wanted) => {
    setAsked(null);
    setChecked(name);
    await operations.attempt("plant" in body ? "Plant not changed" : "Actuator not changed", () =>
      "plant" in body ? presets.plant(body) : presets.change(body),
    );
    setChecked(null);
  };
  return (
    <div className="panel">
      <Choice
        choice={choice}
        current={rig.parameters.actuator.name}
        plant={rig.twin ? rig.parameters.twin.plant : null}
        checked={checked}
        want={setAsked}
      />
      <Facts facts={actuatorFacts(rig.parameters.actuator)} testId="actuator-facts" />
      <AskActuator
        wanted={asked?.name ?? null}
        onClose={() => setAsked(null)}
        onYes={() => {
          if (asked) void change(asked);
        }}
      />
    </div>
  );
}

/** Why no other actuator can be chosen now, null when one can. */
function useWhyNot(choice: ActuatorChoice | null, checked: string | null): string | null {
  const because = useWhyNoRestart();
  if (!choice) return "Waiting for the server";
  if (choice.reason !== "") return choice.reason;
  return checked === null ? because : `Checking that ${checked} stands and moves`;
}

interface ChoiceProps {
  readonly choice: ActuatorChoice | null;
  readonly current: string;
  /** What simulates it; null on hardware. */
  readonly plant: Plant | null;
  /** The actuator that the server looks at before the rig is ended. */
  readonly checked: string | null;
  readonly want: (wanted: Wanted) => void;
}

function Choice({ choice, current, plant, checked, want }: ChoiceProps) {
  const operations = useService(Operations);
  const starting = usePage((page) => page.starting);
  const because = useWhyNot(choice, checked);
  const waiting = checked !== null || starting !== "";
  const read = (file: File | null) => {
    if (file)
      void operations.attempt("File not read", async () => {
        if (file.size > FILE_MAX)
          throw new Error(`${file.name} has ${file.size} bytes, more than ${FILE_MAX}`);
        want({ name: file.name, body: { name: null, toml: await file.text() } });
      });
  };
  return (
    <>
      <div className="row" role="group" aria-label="Actuator">
        <Choices
          choices={(choice?.names ?? []).map(actuatorNamed)}
          current={current}
          kind="actuator"
          because={because}
          want={want}
        />
        <FileButton accept=".toml" onChange={read}>
          {({ onClick }) => (
            <ControlButton
              control="settings"
              because={because}
              variant="default"
              leftSection={<IconFileUpload size={15} />}
              testId="actuator-file"
              meaning="Start the rig again with an actuator described in a TOML file"
              onClick={onClick}
            >
              From a file
            </ControlButton>
          )}
        </FileButton>
        {waiting ? <Loader size="xs" aria-hidden /> : null}
      </div>
      {plant === null ? null : <SimulatedBy plant={plant} because={because} want={want} />}
      {choice && choice.failure !== "" && !waiting ? (
        <p className="note" role="alert" data-testid="actuator-failure">
          {choice.failure}
        </p>
      ) : null}
      <p className="note" role="status" data-testid="actuator-status">
        {because ?? "Choosing one starts the rig again, vented."}
        {waiting ? <Elapsed key={`${checked ?? ""}${starting}`} /> : null}
      </p>
    </>
  );
}

const actuatorNamed = (name: string) => ({
  id: name,
  word: name,
  meaning: `Start the rig again with ${name}`,
  wanted: { name, body: { name, toml: null } },
});

/** How long this has been going on. */
function Elapsed() {
  const [begin] = useState(() => performance.now());
  return (
    <span className="number" aria-hidden>
      {" · "}
      <LiveText read={() => seconds((performance.now() - begin) / 1e3)} rate={4} />
    </span>
  );
}

/** What is said about an actuator: name and value of each fact. */
function actuatorFacts(actuator: Actuator): [string, string][] {
  const {
    name,
    length,
    width,
    height,
    mass,
    u_max,
    pressure_max,
    pressure_map,
    stiffening,
    stretching,
    tip_load,
    k,
  } = actuator;
  const facts: [string, string][] = [
    ["Name", name],
    ["Length", millimetres(length, 0)],
    ["Width × height", `${plain(width * 1e3, 1)} × ${millimetres(height)}`],
    ["Mass", `${plain(mass * GRAM, 0)} g`],
    ["Joint stiffness", `${range(k)} N m/rad`],
    ["Torque limit", `${plain(u_max * 1e3, 0)} mN m`],
    ["Highest pressure", kilopascals(pressure_max)],
  ];
  const slopes = pressure_map.length === 4 ? pressure_map : pressure_map.flatMap((pair) => [pair, pair]);
  const slope = (j: number): number => slopes.slice(2 * j, 2 * j + 2).reduce((sum, one) => sum + one / 2, 0);
  const percent = (shares: readonly number[], digits: number) =>
    shares.map((share, j) => `${plain(100 * share * u_max * slope(j), digits)} %`).join(", ");
  if (stiffening.some((share) => share > 0))
    facts.push(["Stiffer at that torque by", percent(stiffening, 0)]);
  if (stretching.some((share) => share > 0)) facts.push(["Longer at that torque by", percent(stretching, 1)]);
  if (tip_load > 0) facts.push(["Tip load", `${plain(tip_load * GRAM, 0)} g`]);
  return facts;
}

/** A profile as one number, or from its lowest to its highest. */
function range(profile: readonly number[]): string {
  const [low, high] = [Math.min(...profile), Math.max(...profile)].map((value) => value.toPrecision(3));
  return low === high ? low : `${low} … ${high}`;
}
