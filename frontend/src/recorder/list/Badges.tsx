import type { Recording } from "../../api/types";
import { marksOf } from "./listing";

interface Props {
  readonly row: Recording;
  readonly running: boolean;
}

/** What is remarkable about a recording, and its tags. */
export function Badges({ row, running }: Props) {
  const marks = marksOf(row, running);
  return (
    <>
      {marks.map(({ text, reason, bad }) => (
        <span
          key={text}
          className={bad ? "review-badge review-bad" : "review-badge"}
          title={reason}
          data-testid="mark"
        >
          {bad ? "▲ " : ""}
          {text}
        </span>
      ))}
      {row.tags.map((tag) => (
        <span key={tag} className="note review-tag" title={`#${tag}`}>
          #{tag}
        </span>
      ))}
      {marks.length === 0 ? null : (
        <span className="sr-only">{marks.map(({ text, reason }) => `${text}: ${reason}`).join(" ")}</span>
      )}
    </>
  );
}
