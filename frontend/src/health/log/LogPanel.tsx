import { SegmentedControl } from "@mantine/core";
import { useState } from "react";
import type { LogEntry } from "../../api/types";
import { usePage, type LogLine } from "../../live/page";
import { localTime, timeOfDay } from "../../ui/format";

const MARK = { info: "", warning: "▲ ", error: "✖ " } as const;
const RANK = { info: 0, warning: 1, error: 2 } as const;

type Level = LogEntry["level"];

/** Who did what, what was refused, what the rig did by itself; newest first. */
export function LogPanel() {
  const log = usePage((page) => page.log);
  const [least, setLeast] = useState<Level>("info");
  const of = (level: Level) => log.filter((line) => RANK[line.level] >= RANK[level]);
  const shown = of(least);
  return (
    <div className="log-panel">
      <div className="row log-bar">
        <SegmentedControl
          size="xs"
          aria-label="Lines shown"
          value={least}
          onChange={setLeast}
          data={[
            { value: "info", label: "All" },
            { value: "warning", label: `Warnings ${of("warning").length}` },
            { value: "error", label: `Errors ${of("error").length}` },
          ]}
        />
        <span className="note">newest first, local time</span>
      </div>
      {shown.length === 0 ? (
        <p className="panel note">{log.length === 0 ? "Nothing happened yet." : "Nothing of this kind."}</p>
      ) : (
        <ol className="log" data-testid="log" aria-label="Event log" tabIndex={0}>
          {shown.map((line) => (
            <Line key={line.key} line={line} />
          ))}
        </ol>
      )}
    </div>
  );
}

function Line({ line: { time, level, text, count } }: { readonly line: LogLine }) {
  return (
    <li className={`log-${level}`}>
      <time className="number" dateTime={time} title={localTime(time)}>
        {timeOfDay(time)}
      </time>
      <span>
        <span aria-hidden>{MARK[level]}</span>
        {level === "info" ? null : <span className="sr-only">{level}: </span>}
        {text}
        {count > 1 ? <b className="number log-count"> × {count}</b> : null}
      </span>
    </li>
  );
}
