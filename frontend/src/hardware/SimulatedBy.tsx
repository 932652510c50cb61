import { TextInput } from "@mantine/core";
import { useState } from "react";
import { ControlButton } from "../operate/ControlButton";
import type { Plant, Wanted } from "../operate/presets/presets";
import { Choices, type Choice } from "./Choices";

/** What simulates the actuator, in the order in which it is offered. */
const PLANTS: readonly Choice[] = [
  {
    id: "rod",
    word: "Rigid rods",
    meaning: "A finer chain of rods, of the kind that the observer has; the rig starts again",
    wanted: { name: "a plant of rigid rods", body: { plant: "rod", numbers: null } },
  },
  {
    id: "cosserat",
    word: "Cosserat rod",
    meaning: "Foreign to the observer: it stretches, shears, and pressure stiffens it; the rig starts again",
    wanted: { name: "a Cosserat rod as plant", body: { plant: "cosserat", numbers: null } },
  },
];

interface Props {
  readonly plant: Plant;
  /** Why nothing can be chosen now, null when it can. */
  readonly because: string | null;
  readonly want: (wanted: Wanted) => void;
}

/** The twin's plant and its numbers, where they are not to be those of the actuator's file or of the fit. */
export function SimulatedBy({ plant, because, want }: Props) {
  const [numbers, setNumbers] = useState("");
  const given = numbers.trim();
  return (
    <>
      <div className="row" role="group" aria-label="Simulated by">
        <span className="note">Simulated by</span>
        <Choices choices={PLANTS} current={plant} kind="plant" because={because} want={want} />
      </div>
      <div className="row" role="group" aria-label="Numbers of the twin">
        <span className="note" aria-hidden>
          Its numbers
        </span>
        <TextInput
          size="xs"
          className="grows"
          aria-label="Numbers of the twin"
          placeholder="kappa=12, zeta=0.2, friction=0.05"
          value={numbers}
          onChange={(event) => setNumbers(event.currentTarget.value)}
          data-testid="twin-numbers"
        />
        <ControlButton
          control="settings"
          because={because}
          variant="default"
          testId="twin-numbers-set"
          meaning="Start the twin again with these numbers; with none, those of the actuator's file or of the fit"
          onClick={() =>
            want({ name: given === "" ? "the twin's usual numbers" : given, body: { plant, numbers: given } })
          }
        >
          {given === "" ? "Usual numbers" : "Set"}
        </ControlButton>
      </div>
    </>
  );
}
