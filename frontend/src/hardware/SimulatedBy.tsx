import { TextInput } from "@mantine/core";
import { useState } from "react";
import { ControlButton } from "../operate/ControlButton";
import type { Plant, Wanted } from "../operate/presets/presets";

/** What simulates the actuator, in the order in which it is offered. */
const PLANTS = [
  {
    plant: "rod",
    word: "Rigid rods",
    called: "a plant of rigid rods",
    meaning: "A finer chain of rods, of the kind that the observer has",
  },
  {
    plant: "cosserat",
    word: "Cosserat rod",
    called: "a Cosserat rod as plant",
    meaning: "Foreign to the observer: it stretches, shears, and pressure stiffens it",
  },
] as const satisfies readonly { readonly plant: Plant; word: string; called: string; meaning: string }[];

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
        {PLANTS.map(({ plant: one, word, called, meaning }) => (
          <ControlButton
            key={one}
            control="settings"
            because={one === plant ? "The rig has it" : because}
            variant="default"
            className="actuator"
            aria-pressed={one === plant}
            testId={`plant-${one}`}
            meaning={`${meaning}; the rig starts again`}
            onClick={() => want({ name: called, body: { plant: one, numbers: null } })}
          >
            {word}
          </ControlButton>
        ))}
      </div>
      <div className="row" role="group" aria-label="Numbers of the twin">
        <TextInput
          size="xs"
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
