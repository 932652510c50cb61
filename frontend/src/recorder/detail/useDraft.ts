import { useEffect, useRef, useState } from "react";

/** What is written into a field over `kept`; `keep` gets it when the field is left, be it by leaving the view. */
export function useDraft(kept: string, keep: (text: string) => void) {
  const [text, setText] = useState(kept);
  const left = useRef(kept);
  const leave = () => {
    if (text === kept) return;
    left.current = text;
    keep(text);
  };
  const vanish = useRef(leave);
  useEffect(() => {
    vanish.current = () => {
      if (text !== left.current) leave();
    };
  });
  useEffect(
    () => () => {
      vanish.current();
    },
    [],
  );
  return { text, write: setText, leave };
}
