import { timeOfDay } from "../state/format";
import { usePage } from "./context";

const MARK = { info: "", warning: "⚠ ", error: "✖ " } as const;

/** Who did what, what was refused, what the rig did by itself; newest first. */
export function LogPanel() {
  const log = usePage((page) => page.log);
  if (log.length === 0) return <p className="panel note">Nothing happened yet.</p>;
  return (
    <ol className="log" data-testid="log">
      {log.map(({ key, time, level, text }) => (
        <li key={key} className={`log-${level}`}>
          <time className="number" dateTime={time}>
            {timeOfDay(time)}
          </time>
          <span>
            {MARK[level]}
            {text}
          </span>
        </li>
      ))}
    </ol>
  );
}
