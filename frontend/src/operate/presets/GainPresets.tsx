import { ActionIcon, Button, Menu, ScrollArea, TextInput } from "@mantine/core";
import { IconFolderOpen, IconTrash } from "@tabler/icons-react";
import { useCallback, useState } from "react";
import { ControlButton } from "../ControlButton";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { gainsOf } from "../settings";
import { useService } from "../../ui/services";
import { presets, type GainPreset } from "./presets";

const NAME = /^[\p{L}\p{N}_ .+-]{1,60}$/u;

/** Gains kept on the server by name: load, save the ones in force, delete. */
export function GainPresets() {
  const operations = useService(Operations);
  const [list, setList] = useState<readonly GainPreset[]>([]);
  const update = useCallback(
    (title: string, action: () => Promise<readonly GainPreset[]>) =>
      void operations.attempt(title, async () => {
        setList(await action());
      }),
    [operations],
  );
  return (
    <Menu
      position="bottom-start"
      shadow="md"
      closeOnItemClick={false}
      trapFocus
      onOpen={() => update("Presets not known", presets.gains)}
    >
      <Menu.Target>
        <Button
          size="xs"
          variant="default"
          leftSection={<IconFolderOpen size={15} />}
          data-testid="gain-presets"
        >
          Presets
        </Button>
      </Menu.Target>
      <Menu.Dropdown>
        <Saved list={list} update={update} />
        <Menu.Divider />
        <Save list={list} update={update} />
      </Menu.Dropdown>
    </Menu>
  );
}

interface ListProps {
  readonly list: readonly GainPreset[];
  readonly update: (title: string, action: () => Promise<readonly GainPreset[]>) => void;
}

function Saved({ list, update }: ListProps) {
  const operations = useService(Operations);
  const reason = useWhyNot("settings");
  return (
    <ScrollArea.Autosize mah={200}>
      {list.map(({ name, settings, built_in }) => (
        <div key={name} className="saved-row">
          <Menu.Item
            closeMenuOnClick
            disabled={reason !== null}
            title={reason ?? `Load ${name}`}
            data-testid="gain-preset"
            onClick={() => void operations.changeSettings("Preset not loaded", gainsOf(settings))}
          >
            {name}
          </Menu.Item>
          {built_in ? null : (
            <ActionIcon
              variant="subtle"
              color="gray"
              disabled={reason !== null}
              title={reason ?? `Delete ${name}`}
              aria-label={`Delete ${name}`}
              onClick={() => update("Preset not deleted", () => presets.remove(name))}
            >
              <IconTrash size={16} />
            </ActionIcon>
          )}
        </div>
      ))}
    </ScrollArea.Autosize>
  );
}

function Save({ list, update }: ListProps) {
  const [name, setName] = useState("");
  const wanted = name.trim();
  const exists = list.some((preset) => preset.name === wanted);
  return (
    <div className="preset-save">
      <TextInput
        size="xs"
        aria-label="Name of the preset"
        placeholder="Name of the preset"
        data-testid="gain-preset-name"
        value={name}
        maxLength={60}
        onChange={(event) => setName(event.currentTarget.value)}
      />
      <ControlButton
        control="settings"
        because={NAME.test(wanted) ? null : "Give it a name of letters, digits and . + - _"}
        variant="default"
        testId="gain-preset-save"
        meaning={exists ? "Replace the preset of this name" : "Save the gains in force"}
        onClick={() => update("Preset not saved", () => presets.save(wanted))}
      >
        {exists ? "Replace" : "Save"}
      </ControlButton>
    </div>
  );
}
