import { FileButton, Loader } from "@mantine/core";
import { IconFileUpload } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import { presets, type ActuatorBody, type ActuatorChoice } from "./presets";
import { MODE } from "../rig/modes";
import { ControlButton } from "../operate/ControlButton";
import { actuatorFacts } from "./actuatorFacts";
import { useDashboard, usePage } from "../ui/context";

/** Longest file that is read. */
const FILE_MAX = 400_000;

/** The rig's actuator, and others to start it with. */
export function ActuatorPanel() {
  const { operations } = useDashboard();
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
      <dl className="facts" data-testid="actuator-facts">
        {actuatorFacts(rig.parameters.actuator).map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd className="number">{value}</dd>
          </div>
        ))}
      </dl>
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
  const { operations } = useDashboard();
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
