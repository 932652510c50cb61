import { ActionIcon, Button } from "@mantine/core";
import { IconPencil, IconPlayerPlayFilled, IconPlus, IconTrash } from "@tabler/icons-react";
import { useState } from "react";
import { usePage } from "../../live/page";
import { ControlButton } from "../../operate/ControlButton";
import { useWhyNot } from "../../operate/permission";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { MacroEditor } from "./MacroEditor";
import { endText, Macros } from "./macros";

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
          onClick={() => {
            macros.edit(null);
          }}
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
            onClick={() => {
              macros.edit(macro);
            }}
          >
            <IconPencil size={16} />
          </ActionIcon>
          <Delete name={macro.name} />
        </li>
      ))}
    </ul>
  );
}

/** Asks once more before it deletes. */
function Delete({ name }: { readonly name: string }) {
  const macros = useService(Macros);
  const [sure, setSure] = useState(false);
  const reason = useWhyNot("edit");
  const label = sure ? `Really delete ${name}?` : `Delete ${name}`;
  return (
    <ActionIcon
      variant={sure ? "filled" : "subtle"}
      color={sure ? "red" : "gray"}
      disabled={reason !== null}
      aria-label={label}
      title={reason ?? label}
      data-testid="macro-delete"
      onBlur={() => {
        setSure(false);
      }}
      onClick={() => {
        if (sure) void macros.remove(name);
        setSure(!sure);
      }}
    >
      <IconTrash size={16} />
    </ActionIcon>
  );
}
