import { ActionIcon, Button, Popover, TextInput, Tooltip } from "@mantine/core";
import { IconLayoutGrid, IconTrash } from "@tabler/icons-react";
import { useState } from "react";
import { DEFAULT_LAYOUT } from "./layout";
import type { Layouts } from "./useLayout";

/** Layouts kept on the server for this browser: open, save under a name, delete. */
export function LayoutMenu({ layouts }: { readonly layouts: Layouts }) {
  const [opened, setOpened] = useState(false);
  const [name, setName] = useState("");
  const save = async () => {
    await layouts.save(name);
    setName("");
  };
  return (
    <Popover opened={opened} onChange={setOpened} position="right-end" width={250} shadow="md" trapFocus>
      <Popover.Target>
        <Tooltip label="Layouts" position="right" disabled={opened}>
          <ActionIcon
            variant="default"
            aria-label="Layouts of plots"
            data-testid="layouts"
            onClick={() => setOpened(!opened)}
          >
            <IconLayoutGrid size={16} />
          </ActionIcon>
        </Tooltip>
      </Popover.Target>
      <Popover.Dropdown>
        <p className="note">Kept on the server, for this browser</p>
        <ul className="layouts">
          <li>
            <button
              type="button"
              className="link"
              onClick={() => layouts.change(() => DEFAULT_LAYOUT)} /* prettier-ignore */
            >
              Default
            </button>
          </li>
          {layouts.names.map((known) => (
            <li key={known}>
              <button
                type="button"
                className="link"
                data-testid="layout-open"
                onClick={() => void layouts.open(known)}
              >
                {known}
              </button>
              <ActionIcon
                variant="subtle"
                color="gray"
                size="xs"
                aria-label={`Delete layout ${known}`}
                onClick={() => void layouts.forget(known)}
              >
                <IconTrash size={14} />
              </ActionIcon>
            </li>
          ))}
        </ul>
        <form
          className="row layout-save"
          onSubmit={(event) => {
            event.preventDefault();
            void save();
          }}
        >
          <TextInput
            size="xs"
            aria-label="Name of the layout"
            placeholder="Save these plots as"
            maxLength={40}
            data-testid="layout-name"
            value={name}
            onChange={(event) => setName(event.currentTarget.value)}
          />
          <Button
            size="xs"
            type="submit"
            variant="default"
            disabled={name.trim() === ""}
            data-testid="layout-save"
          >
            Save
          </Button>
        </form>
      </Popover.Dropdown>
    </Popover>
  );
}
