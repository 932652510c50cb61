import type { Recording } from "../../api/types";
import { marksOf } from "./listing";

interface Props {
  readonly row: Recording;
  readonly running: boolean;
}

/** What is remarkable about a recording, and its tags. */
export function Badges({ row, running }: Props) {
  return (
    <>
      {marksOf(row, running).map(({ text, reason, bad }) => (
        <span
          key={text}
          className={bad ? "review-badge review-bad" : "review-badge"}
          title={reason}
          data-testid="mark"
        >
          {bad ? "▲ " : ""}
          {text}
          <span className="sr-only">: {reason}</span>
        </span>
      ))}
      {row.tags.map((tag) => (
        <span key={tag} className="note review-tag">
          #{tag}
        </span>
      ))}
    </>
  );
}
