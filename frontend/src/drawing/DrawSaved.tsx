import { ActionIcon, Button, Popover, TextInput, Tooltip } from "@mantine/core";
import { IconDownload, IconFolderOpen } from "@tabler/icons-react";
import { useState } from "react";
import { ControlButton } from "../operate/ControlButton";
import { DeleteIcon } from "../operate/DeleteIcon";
import { millimetres } from "../ui/format";
import { useService } from "../ui/services";
import { useStore } from "../ui/store";
import { Drawing, sketchOf, useDrawing } from "./drawing";
import { drawingUrl, SavedDrawings } from "./saved";
import { SourceChoice } from "./SourceChoice";

/** Name and save the drawing; the drawings kept by the server. */
export function DrawSaved() {
  const drawing = useService(Drawing);
  const saved = useService(SavedDrawings);
  const name = useDrawing((state) => state.name);
  const reason = useDrawing((state) =>
    sketchOf(state).pieces.length === 0
      ? "Nothing is drawn"
      : state.name.trim() === ""
        ? "Give it a name first"
        : null,
  );
  const list = useStore(saved.store, (store) => store.list);
  const [opened, setOpened] = useState(false);
  return (
    <div className="row run-row">
      <SourceChoice />
      <TextInput
        size="xs"
        w={150}
        aria-label="Name of the drawing"
        placeholder="Name of the drawing"
        maxLength={80}
        data-testid="drawing-name"
        value={name}
        onChange={(event) => drawing.rename(event.currentTarget.value)}
      />
      <ControlButton
        control="settings"
        because={reason}
        variant="default"
        testId="save-drawing"
        meaning={
          list.some((kept) => kept.name === name.trim()) ? "Replace the saved drawing" : "Save on the server"
        }
        onClick={() => void saved.save()}
      >
        Save
      </ControlButton>
      <Popover opened={opened} onChange={setOpened} position="bottom-end" shadow="md" trapFocus returnFocus>
        <Popover.Target>
          <Button
            size="xs"
            variant="default"
            leftSection={<IconFolderOpen size={15} />}
            data-testid="saved-drawings"
            onClick={() => setOpened(!opened)}
          >
            Saved ({list.length})
          </Button>
        </Popover.Target>
        <Popover.Dropdown mah={260} className="draw-list" p={6}>
          <SavedList
            onLoad={(wanted) => {
              setOpened(false);
              void saved.load(wanted);
            }}
          />
        </Popover.Dropdown>
      </Popover>
    </div>
  );
}

function SavedList({ onLoad }: { readonly onLoad: (name: string) => void }) {
  const saved = useService(SavedDrawings);
  const list = useStore(saved.store, (store) => store.list);
  if (list.length === 0) return <p className="note">Nothing saved yet</p>;
  return (
    <ul className="saved" aria-label="Saved drawings">
      {list.map(({ name, length }) => (
        <li key={name}>
          <Button
            size="xs"
            variant="subtle"
            color="gray"
            className="saved-name"
            justify="start"
            data-testid="saved-drawing"
            onClick={() => onLoad(name)}
          >
            {name} <span className="note number saved-length">{millimetres(length, 0)}</span>
          </Button>
          <Tooltip label="Download what would be followed, as CSV">
            <ActionIcon
              component="a"
              variant="subtle"
              color="gray"
              href={drawingUrl(name)}
              download
              aria-label={`Download ${name}`}
            >
              <IconDownload size={16} />
            </ActionIcon>
          </Tooltip>
          <DeleteIcon
            control="settings"
            name={name}
            testId={`delete-${name}`}
            onDelete={() => void saved.remove(name)}
          />
        </li>
      ))}
    </ul>
  );
}
