import type { PlotChannel } from "../api/types";

/** How a quantity is shown: its display unit, the factor from SI, and the least height of an axis [display unit]. */
export interface Display {
  readonly unit: string;
  readonly scale: number;
  readonly least: number;
}

const DISPLAY: Partial<Record<string, Display>> = {
  m: { unit: "mm", scale: 1e3, least: 5 },
  "m/s": { unit: "mm/s", scale: 1e3, least: 20 },
  "m s": { unit: "mm s", scale: 1e3, least: 0.1 },
  Pa: { unit: "kPa", scale: 1e-3, least: 20 },
  "N m": { unit: "mN m", scale: 1e3, least: 1 },
  s: { unit: "ms", scale: 1e3, least: 1 },
  ns: { unit: "µs", scale: 1e-3, least: 10 },
  J: { unit: "mJ", scale: 1e3, least: 1e-6 },
  W: { unit: "mW", scale: 1e3, least: 1e-3 },
  "1": { unit: "", scale: 1, least: 1 },
};

export function displayOf(unit: string): Display {
  return DISPLAY[unit] ?? { unit, scale: 1, least: 1e-9 };
}

/** "reference x", or only "energy". */
export function labelOf(channel: PlotChannel): string {
  if (channel.name === "norm") return `|${channel.group}|`;
  return channel.name === "" ? channel.group : `${channel.group} ${channel.name}`;
}

export interface MenuGroup {
  readonly group: string;
  readonly items: { readonly value: string; readonly label: string; readonly disabled: boolean }[];
}

/** All channels by field. Beside signals of one unit only those of the same unit can be chosen. */
export function menuOf(channels: readonly PlotChannel[], unit: string | null): MenuGroup[] {
  const groups = new Map<string, PlotChannel[]>();
  for (const channel of channels) groups.set(channel.group, [...(groups.get(channel.group) ?? []), channel]);
  return [...groups].map(([group, members]) => {
    const shown = displayOf(members[0].unit).unit;
    const items = members.map((channel) => ({
      value: channel.key,
      label: labelOf(channel),
      disabled: unit !== null && channel.unit !== unit,
    }));
    return { group: shown === "" ? group : `${group} [${shown}]`, items };
  });
}

/** Whether every word of `query` is somewhere in `text`: "pres 2" finds "pressure command 2". */
export function matches(text: string, query: string): boolean {
  const low = text.toLowerCase();
  return query
    .toLowerCase()
    .split(/\s+/)
    .every((word) => low.includes(word));
}
