import { FileButton, Loader } from "@mantine/core";
import { IconFileUpload } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import type { RigInfo } from "../api/types";
import { usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { Operations } from "../operate/operations";
import { MODE } from "../rig/modes";
import { Facts } from "../ui/Facts";
import { kilopascals, millimetres, plain } from "../ui/format";
import { useService } from "../ui/services";
import { presets, type ActuatorBody, type ActuatorChoice } from "./presets";

type Actuator = RigInfo["parameters"]["actuator"];
const GRAM = 1e3;
/** Longest file that is read. */
const FILE_MAX = 400_000;

/** The rig's actuator, and others to start it with. */
export function ActuatorPanel() {
  const operations = useService(Operations);
  const rig = usePage((page) => page.rig);
  const online = usePage((page) => page.online);
  const boot = rig?.boot;
  const [choice, setChoice] = useState<ActuatorChoice | null>(null);
  /** Life of the rig that was there when another actuator was asked for. */
  const [left, setLeft] = useState<number | null>(null);
  useEffect(() => {
    // Whether the rig is the server's own, and how it started with the last choice, is known by the server alone.
    if (!online) return;
    void operations.attempt("Actuators not known", async () => {
      setChoice(await presets.actuators());
    });
  }, [operations, online, boot]);
  if (!rig) return <p className="panel note">Waiting for the rig.</p>;
  const waiting = left === rig.boot;
  const change = (body: ActuatorBody) => {
    void operations.attempt("Actuator not changed", async () => {
      await presets.change(body);
      setLeft(rig.boot);
    });
  };
  return (
    <div className="panel">
      <Choice choice={choice} current={rig.parameters.actuator.name} waiting={waiting} change={change} />
      <Facts facts={actuatorFacts(rig.parameters.actuator)} testId="actuator-facts" />
    </div>
  );
}

interface ChoiceProps {
  readonly choice: ActuatorChoice | null;
  readonly current: string;
  readonly waiting: boolean;
  readonly change: (body: ActuatorBody) => void;
}

function Choice({ choice, current, waiting, change }: ChoiceProps) {
  const mode = usePage((page) => page.mode);
  const rigLive = usePage((page) => page.rigLive);
  const operations = useService(Operations);
  const because = !choice
    ? "Waiting for the server"
    : choice.reason !== ""
      ? choice.reason
      : waiting || !rigLive
        ? "The rig is starting"
        : mode === MODE.VENTED
          ? null
          : "Disarm first: the rig starts again";
  const read = (file: File | null) => {
    if (file)
      void operations.attempt("File not read", async () => {
        if (file.size > FILE_MAX)
          throw new Error(`${file.name} has ${file.size} bytes, more than ${FILE_MAX}`);
        change({ name: null, toml: await file.text() });
      });
  };
  return (
    <>
      <div className="row" role="group" aria-label="Actuator">
        {choice?.names.map((name) => (
          <ControlButton
            key={name}
            control="settings"
            because={name === current ? "The rig has it" : because}
            variant="default"
            className="actuator"
            aria-pressed={name === current}
            testId={`actuator-${name}`}
            meaning={`Start the rig again with ${name}`}
            onClick={() => {
              change({ name, toml: null });
            }}
          >
            {name}
          </ControlButton>
        ))}
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
        {waiting ? <Loader size="xs" aria-label="The rig is starting" /> : null}
      </div>
      {choice && choice.failure !== "" && !waiting ? (
        <p className="note" role="alert" data-testid="actuator-failure">
          {choice.failure}
        </p>
      ) : null}
      <p className="note" role="status" data-testid="actuator-status">
        {waiting
          ? "The rig starts again; it comes back vented."
          : (because ?? "Choosing one starts the rig again, vented.")}
      </p>
    </>
  );
}

/** What is said about an actuator: name and value of each fact. */
function actuatorFacts(actuator: Actuator): [string, string][] {
  const { name, length, width, height, mass, u_max, pressure_max, tip_load, k } = actuator;
  const facts: [string, string][] = [
    ["Name", name],
    ["Length", millimetres(length, 0)],
    ["Width × height", `${plain(width * 1e3, 1)} × ${millimetres(height)}`],
    ["Mass", `${plain(mass * GRAM, 0)} g`],
    ["Joint stiffness", `${range(k)} N m/rad`],
    ["Torque limit", `${plain(u_max * 1e3, 0)} mN m`],
    ["Highest pressure", kilopascals(pressure_max)],
  ];
  if (tip_load > 0) facts.push(["Tip load", `${plain(tip_load * GRAM, 0)} g`]);
  return facts;
}

/** A profile as one number, or from its lowest to its highest. */
function range(profile: readonly number[]): string {
  const [low, high] = [Math.min(...profile), Math.max(...profile)].map((value) => value.toPrecision(3));
  return low === high ? low : `${low} … ${high}`;
}
