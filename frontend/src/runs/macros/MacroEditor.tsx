import { ActionIcon, Button, NativeSelect, TextInput } from "@mantine/core";
import { IconArrowDown, IconArrowUp, IconPlus, IconX } from "@tabler/icons-react";
import type { MacroStep } from "../../api/types";
import { ControlButton } from "../../operate/ControlButton";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { KINDS, Macros, moved, whyNotSaved, type Draft } from "./macros";
import { StepFields } from "./StepFields";

const LIST = Object.values(KINDS).map(([label, { do: value }]) => ({ value, label }));

/** Name and steps of one macro, until it is saved or dropped. */
export function MacroEditor({ draft }: { readonly draft: Draft }) {
  const macros = useService(Macros);
  const list = useStore(macros.store, (state) => state.list);
  const { name, steps } = draft;
  const put = (next: readonly MacroStep[]) => macros.change({ steps: next });
  return (
    <>
      <TextInput
        size="xs"
        maw={320}
        label="Name of the macro"
        autoFocus
        maxLength={40}
        data-testid="macro-name"
        value={name}
        onChange={(event) => macros.change({ name: event.currentTarget.value })}
      />
      <ol className="macro-steps" aria-label="Steps">
        {steps.map((step, i) => (
          // The place of a step is its name: it has no other.
          <li key={`${i} ${step.do}`} data-testid="macro-step">
            <span className="macro-fields">
              <NativeSelect
                size="xs"
                aria-label={`Step ${i + 1}`}
                data={LIST}
                value={step.do}
                onChange={(event) => {
                  const chosen = LIST.find(({ value }) => value === event.currentTarget.value);
                  if (chosen) put(steps.with(i, KINDS[chosen.value][1]));
                }}
              />
              <span className="macro-given">
                <StepFields step={step} change={(next) => put(steps.with(i, next))} />
              </span>
            </span>
            <StepButtons steps={steps} i={i} put={put} />
          </li>
        ))}
      </ol>
      <div className="row">
        <Button
          size="xs"
          variant="default"
          leftSection={<IconPlus size={14} />}
          data-testid="macro-add"
          onClick={() => put([...steps, KINDS.wait[1]])}
        >
          Add a step
        </Button>
        <span className="spacer" />
        <Button size="xs" variant="default" data-testid="macro-drop" onClick={() => macros.drop()}>
          Cancel
        </Button>
        <ControlButton
          control="edit"
          because={whyNotSaved(draft, list)}
          variant="default"
          testId="macro-save"
          meaning="Keep it on the server, for this browser"
          onClick={() => void macros.save()}
        >
          Save
        </ControlButton>
      </div>
    </>
  );
}

interface ButtonsProps {
  readonly steps: readonly MacroStep[];
  readonly i: number;
  readonly put: (steps: readonly MacroStep[]) => void;
}

function StepButtons({ steps, i, put }: ButtonsProps) {
  const all = [
    [`Move step ${i + 1} up`, IconArrowUp, i > 0, () => moved(steps, i, -1)],
    [`Move step ${i + 1} down`, IconArrowDown, i + 1 < steps.length, () => moved(steps, i, 1)],
    [`Remove step ${i + 1}`, IconX, true, () => steps.toSpliced(i, 1)],
  ] as const;
  return all.map(([label, Glyph, possible, next]) => (
    <ActionIcon
      key={label}
      variant="subtle"
      color="gray"
      size="sm"
      aria-label={label}
      title={label}
      disabled={!possible}
      onClick={() => put(next())}
    >
      <Glyph size={15} />
    </ActionIcon>
  ));
}
