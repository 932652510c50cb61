import {
  ActionIcon,
  Button,
  MultiSelect,
  Popover,
  type ComboboxItem,
  type OptionsFilter,
} from "@mantine/core";
import { IconSettings, IconTrash } from "@tabler/icons-react";
import type { PlotChannel } from "../api/types";
import { LINES_MAX } from "./layout";
import { matches, menuOf } from "./signals";

interface Props {
  readonly title: string;
  readonly opened: boolean;
  readonly onOpened: (opened: boolean) => void;
  readonly channels: readonly PlotChannel[];
  readonly chosen: readonly string[];
  readonly onChosen: (keys: readonly string[]) => void;
  readonly onRemove: () => void;
}

/** Which signals a plot shows: all of telemetry, by field, found by typing. One plot has one unit. */
export function SignalChooser({ title, opened, onOpened, channels, chosen, onChosen, onRemove }: Props) {
  const unit = channels.find(({ key }) => chosen.includes(key))?.unit ?? null;
  return (
    <Popover
      opened={opened}
      onChange={onOpened}
      position="top-end"
      width={340}
      shadow="md"
      trapFocus
      withinPortal
    >
      <Popover.Target>
        <ActionIcon
          variant="subtle"
          color="gray"
          size="xs"
          aria-label={`Signals of ${title}`}
          data-testid="signals"
          onClick={() => onOpened(!opened)}
        >
          <IconSettings size={14} />
        </ActionIcon>
      </Popover.Target>
      <Popover.Dropdown className="signals">
        <MultiSelect
          size="xs"
          label="Signals"
          description={
            unit === null ? "Any telemetry channel" : "Of one unit; take another plot for another unit"
          }
          placeholder="Type to search"
          data-testid="signal-search"
          data-autofocus
          data={menuOf(channels, unit)}
          filter={search}
          searchable
          clearable
          maxValues={LINES_MAX}
          maxDropdownHeight={240}
          comboboxProps={{ withinPortal: false, position: "top" }}
          nothingFoundMessage="No such signal"
          value={[...chosen]}
          onChange={onChosen}
        />
        <Button
          size="compact-xs"
          variant="subtle"
          color="red"
          leftSection={<IconTrash size={14} />}
          data-testid="remove-plot"
          onClick={onRemove}
        >
          Remove this plot
        </Button>
      </Popover.Dropdown>
    </Popover>
  );
}

/** A group's own name is searched too: "torque 1" finds element 1 of every torque. */
const search: OptionsFilter = ({ options, search: query, limit }) =>
  options
    .map((option) => {
      if (!("group" in option)) return option;
      return { ...option, items: option.items.filter(({ label }: ComboboxItem) => matches(label, query)) };
    })
    .filter((option) => !("items" in option) || option.items.length > 0)
    .slice(0, limit);
