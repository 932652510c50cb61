import { Popover, TextInput } from "@mantine/core";
import { IconBookmark } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import { usePage, type Marked } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { plain } from "../ui/format";
import { useService } from "../ui/services";
import { Recorder } from "./recorder";

/** A label no one begins to type within this time is none [ms]. */
const UNTOUCHED_MS = 10_000;

/** Bookmarks the running recording; then its label can be typed, in a field that lies over the page. */
export function MarkButton() {
  const recorder = useService(Recorder);
  const marked = usePage((page) => page.marked);
  return (
    <Popover
      opened={marked !== null}
      position="bottom-end"
      trapFocus={false}
      returnFocus
      width={260}
      shadow="md"
      withRoles={false}
      closeOnEscape={false}
    >
      <Popover.Target>
        <span>
          <ControlButton
            control="mark"
            variant="default"
            testId="mark-button"
            meaning="Bookmark the newest row (B)"
            px={8}
            leftSection={<IconBookmark size={14} />}
            onClick={() => void recorder.mark()}
          >
            <span className="word-or-icon">Mark</span>
          </ControlButton>
        </span>
      </Popover.Target>
      <Popover.Dropdown
        p={8}
        role="dialog"
        aria-label="Label of the bookmark"
        onKeyDownCapture={({ key }) => {
          if (key === "Escape" && marked) void recorder.label(marked, "");
        }}
      >
        {marked ? <Label key={marked.n} marked={marked} /> : null}
      </Popover.Dropdown>
    </Popover>
  );
}

/** Enter or leaving it keeps what was typed; so does what takes the field away, as another view does. Esc drops it. */
function Label({ marked }: { readonly marked: Marked }) {
  const recorder = useService(Recorder);
  const [text, setText] = useState("");
  const newest = useRef("");
  useEffect(() => () => void recorder.label(marked, newest.current), [recorder, marked]);
  const untouched = text === "";
  useEffect(() => {
    if (!untouched) return undefined;
    const close = setTimeout(() => void recorder.label(marked, ""), UNTOUCHED_MS);
    return () => {
      clearTimeout(close);
    };
  }, [recorder, marked, untouched]);
  return (
    <TextInput
      size="xs"
      autoFocus
      label={`Label of bookmark ${marked.n}, at ${plain(marked.t, 2)} s`}
      placeholder="optional, Enter keeps it"
      maxLength={80}
      data-testid="mark-label"
      value={text}
      onChange={(event) => {
        newest.current = event.currentTarget.value;
        setText(newest.current);
      }}
      onKeyDown={(event) => {
        if (event.key === "Enter") void recorder.label(marked, text);
      }}
      onBlur={() => void recorder.label(marked, text)}
    />
  );
}
