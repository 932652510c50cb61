import { ActionIcon, Button } from "@mantine/core";
import {
  IconPencil,
  IconPlayerPlayFilled,
  IconPlayerStopFilled,
  IconPlaylist,
  IconPlus,
} from "@tabler/icons-react";
import { usePage } from "../../live/page";
import { ControlButton } from "../../operate/ControlButton";
import { DeleteIcon } from "../../operate/DeleteIcon";
import { useWhyNot } from "../../operate/permission";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { MacroEditor } from "./MacroEditor";
import { endText, Macros, stepText, titleOf } from "./macros";

/** My macros: run by one button, written and deleted; how the last one ended. */
export function MacroPanel() {
  const macros = useService(Macros);
  const list = useStore(macros.store, (state) => state.list);
  const draft = useStore(macros.store, (state) => state.draft);
  const reason = useWhyNot("edit");
  return (
    <section className="panel macros" aria-label="Macros">
      <div className="macro-bar-title">
        <h3 className="bar-title">Macros</h3>
        <Last />
        <Button
          size="xs"
          variant="default"
          leftSection={<IconPlus size={14} />}
          disabled={reason !== null || draft !== null}
          title={reason ?? "A list of actions that one button runs"}
          data-testid="macro-new"
          data-focus-home
          onClick={() => macros.edit(null)}
        >
          New
        </Button>
      </div>
      {draft ? <MacroEditor draft={draft} /> : <List />}
      {list.length === 0 && !draft ? (
        <p className="note">A macro does several actions by one button. None is kept for this browser.</p>
      ) : null}
    </section>
  );
}

function Last() {
  const text = usePage(({ macro }) =>
    macro && macro.state !== "running" ? `${macro.name}: ${endText(macro)}` : "",
  );
  return (
    <span className="note" role="status" data-testid="macro-last">
      {text}
    </span>
  );
}

function List() {
  const macros = useService(Macros);
  const list = useStore(macros.store, (state) => state.list);
  const running = usePage(({ macro }) => (macro?.state === "running" ? macro.name : ""));
  return (
    <ul className="macro-list">
      {list.map((macro) => (
        <li key={macro.name} data-testid="macro">
          <span className="macro-name">{macro.name}</span>
          <span className="note">{macro.steps.length === 1 ? "1 step" : `${macro.steps.length} steps`}</span>
          <ControlButton
            control="settings"
            because={running === "" ? null : `Macro ${running} runs`}
            variant="default"
            leftSection={<IconPlayerPlayFilled size={12} />}
            testId="macro-run"
            meaning={`Do the steps of ${macro.name}, one after the other`}
            onClick={() => void macros.run(macro.name)}
          >
            Run
          </ControlButton>
          <ActionIcon
            variant="subtle"
            color="gray"
            aria-label={`Edit ${macro.name}`}
            data-testid="macro-edit"
            onClick={() => macros.edit(macro)}
          >
            <IconPencil size={16} />
          </ActionIcon>
          <DeleteIcon
            control="edit"
            name={macro.name}
            testId="macro-delete"
            onDelete={() => void macros.remove(macro.name)}
          />
        </li>
      ))}
    </ul>
  );
}

/** To everyone: the macro that runs, its step, and the way to stop it. */
export function MacroBar() {
  const macros = useService(Macros);
  const macro = usePage((page) => page.macro);
  if (macro?.state !== "running") return null;
  return (
    <div className="over-page macro-bar" role="status" data-testid="macro-bar">
      <IconPlaylist size={18} aria-hidden />
      <span>
        {titleOf(macro)}: {stepText(macro)}
      </span>
      <ControlButton
        control="settings"
        size="compact-sm"
        variant="default"
        testId="macro-stop"
        meaning="End the macro, and hold what it has set in motion; any stop does so too"
        leftSection={<IconPlayerStopFilled size={14} />}
        onClick={() => void macros.stop()}
      >
        Stop
      </ControlButton>
    </div>
  );
}
