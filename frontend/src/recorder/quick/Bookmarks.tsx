import { ActionIcon, TextInput } from "@mantine/core";
import { IconX } from "@tabler/icons-react";
import type { Bookmark, Recording } from "../../api/types";
import { useWhyNot } from "../../operate/permission";
import { plain } from "../../ui/format";
import { useDraft } from "../detail/useDraft";
import type { Recordings } from "../useRecordings";

interface Props {
  readonly recording: Recording;
  readonly recordings: Recordings;
  readonly onSeek: (at: number) => void;
}

/** What was marked while it ran: a click shows the place, the label is kept when its field is left. */
export function Bookmarks({ recording: { id, bookmarks }, recordings, onSeek }: Props) {
  if (bookmarks.length === 0) return null;
  return (
    <ul className="bookmarks" aria-label="Bookmarks" data-testid="bookmarks">
      {bookmarks.map((mark) => (
        <Entry
          key={`${mark.n} ${mark.label}`}
          mark={mark}
          onSeek={onSeek}
          onLabel={(label) => void recordings.label(id, mark.n, label)}
        />
      ))}
    </ul>
  );
}

interface EntryProps {
  readonly mark: Bookmark;
  readonly onSeek: (at: number) => void;
  readonly onLabel: (label: string | null) => void;
}

function Entry({ mark, onSeek, onLabel }: EntryProps) {
  const reason = useWhyNot("edit");
  const label = useDraft(mark.label, onLabel);
  return (
    <li className="bookmark" title={reason ?? undefined}>
      <button
        type="button"
        className="link number"
        aria-label={`Show bookmark ${mark.n}`}
        data-testid="bookmark-seek"
        onClick={() => onSeek(mark.t)}
      >
        {plain(mark.t, 2)} s
      </button>
      <TextInput
        size="xs"
        aria-label={`Label of bookmark ${mark.n}`}
        placeholder={`bookmark ${mark.n}`}
        readOnly={reason !== null}
        maxLength={80}
        w={150}
        title={label.text}
        data-testid="bookmark-label"
        value={label.text}
        onChange={(event) => label.write(event.currentTarget.value)}
        onKeyDown={(event) => {
          if (event.key === "Enter") event.currentTarget.blur();
        }}
        onBlur={label.leave}
      />
      <ActionIcon
        variant="subtle"
        color="gray"
        size="sm"
        disabled={reason !== null}
        aria-label={`Remove bookmark ${mark.n}`}
        data-testid="bookmark-remove"
        onClick={() => onLabel(null)}
      >
        <IconX size={14} />
      </ActionIcon>
    </li>
  );
}
