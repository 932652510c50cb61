import type { ReferenceInfo } from "../../api/types";
import { hertz, millimetres, millimetresPerSecond, seconds } from "../../ui/format";

interface Group {
  readonly group: string;
  readonly items: { readonly value: string; readonly label: string }[];
}

/** The menu: references grouped by task, in the server's order. */
export function menuOf(references: readonly ReferenceInfo[]): Group[] {
  const groups = new Map<string, Group>();
  for (const { task, name, title, reachable } of references) {
    const group = groups.get(task) ?? { group: task, items: [] };
    group.items.push({ value: name, label: reachable ? title : `${title} (out of reach)` });
    groups.set(task, group);
  }
  return [...groups.values()];
}

/** What is said about a reference: name and value of each fact. */
export function factsOf(info: ReferenceInfo): [string, string][] {
  const facts: [string, string][] = [
    ["Length", millimetres(info.length, 0)],
    ["Duration", seconds(info.duration)],
    ["Peak speed", info.peak_speed === null ? "jumps" : millimetresPerSecond(info.peak_speed)],
  ];
  if (info.frequency !== null) facts.push(["Frequency", hertz(info.frequency)]);
  if (info.reachable && info.approach > 0) facts.push(["From rest", seconds(info.approach)]);
  return facts;
}
