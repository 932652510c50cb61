import { ControlButton } from "../operate/ControlButton";
import type { Wanted } from "../operate/presets/presets";

export interface Choice {
  /** As the server names it. */
  readonly id: string;
  readonly word: string;
  readonly meaning: string;
  readonly wanted: Wanted;
}

interface Props {
  readonly choices: readonly Choice[];
  /** What the rig has. */
  readonly current: string;
  /** What the test ids of the buttons begin with. */
  readonly kind: string;
  /** Why nothing can be chosen now, null when it can. */
  readonly because: string | null;
  readonly want: (wanted: Wanted) => void;
}

/** A button for each choice, the one that the rig has pressed in. */
export function Choices({ choices, current, kind, because, want }: Props) {
  return choices.map(({ id, word, meaning, wanted }) => (
    <ControlButton
      key={id}
      control="settings"
      because={id === current ? "The rig has it" : because}
      variant="default"
      className="actuator"
      aria-pressed={id === current}
      testId={`${kind}-${id}`}
      meaning={meaning}
      onClick={() => want(wanted)}
    >
      {word}
    </ControlButton>
  ));
}
