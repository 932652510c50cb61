import type { Plot, PlotChannel } from "../../api/types";
import type { ErrorOf } from "../../live/telemetry";
import { LINES, ROLE } from "../../ui/colours";
import { displayOf, labelOf, type Display } from "../signals";

/** One line of a chart: which channel (its place in the server's list), and how it looks. */
export interface Line {
  readonly key: string;
  readonly channel: number;
  /** As short as the other lines of the chart allow. */
  readonly name: string;
  /** Shorter still: as the other named lines allow. */
  readonly tag: string;
  readonly colour: string;
  readonly look: Look;
  /** Its name is written at its end: no role's colour and dash tells what it is. */
  readonly named: boolean;
}

export type Look = "solid" | "dashed" | "dots" | "thin";

export interface Chart extends Display {
  readonly title: string;
  readonly fromZero: boolean;
  readonly lines: readonly Line[];
}

type Style = Pick<Line, "colour" | "look">;

const ROLES: Partial<Record<string, Style>> = {
  p_ref: { colour: ROLE.reference, look: "dashed" },
  target: { colour: ROLE.reference, look: "thin" },
  p_meas: { colour: ROLE.measured, look: "dots" },
  markers: { colour: ROLE.measured, look: "dots" },
  p_hat: { colour: ROLE.observer, look: "solid" },
  backbone: { colour: ROLE.observer, look: "solid" },
  twin_backbone: { colour: ROLE.twin, look: "solid" },
};
const NEVER_NEGATIVE = new Set(["Pa", "s", "ns"]);

/** What the title of a plot of the error adds. */
const ERROR_OF: Record<ErrorOf, string> = {
  measured: ", measured tip",
  estimated: ", estimated tip",
  none: ", no reference",
};

/** A plot of the layout as it is drawn; signals that the server does not have, or of another unit, are left out. Of
 * which tip the error is now stands in the title. */
export function chartOf(plot: Plot, channels: readonly PlotChannel[], errorOf?: ErrorOf): Chart {
  const known = plot.channels.flatMap((key) => channels.find((channel) => channel.key === key) ?? []);
  const found = known.filter(({ unit }) => unit === known[0].unit);
  const styles = stylesOf(found);
  const lines = found.map((channel, i) => ({
    ...styles[i],
    key: channel.key,
    channel: channels.indexOf(channel),
    name: shortName(channel, found),
    tag: shortName(
      channel,
      found.filter((_, j) => styles[j].named),
    ),
  }));
  const ofTip = errorOf && found.some(({ field }) => field === "error") ? ERROR_OF[errorOf] : "";
  const title = `${plot.title === "" ? titleOf(found) : plot.title}${ofTip}`;
  return { ...displayOf(found.at(0)?.unit ?? "1"), title, fromZero: found.every(isMagnitude), lines };
}

function stylesOf(found: readonly PlotChannel[]): (Style & { named: boolean })[] {
  const used = new Set<string>();
  return found.map((channel, i) => {
    const role = ROLES[channel.field];
    if (role && !used.has(role.colour)) {
      used.add(role.colour);
      return { ...role, named: false };
    }
    // A command has the colour of what it commands, in a thin line.
    const commanded = channel.field === "pressure_cmd";
    const colour = LINES[(channel.field.startsWith("pressure_") ? (channel.index ?? 0) : i) % LINES.length];
    return { colour, look: commanded ? "thin" : "solid", named: !commanded && found.length > 1 };
  });
}

function shortName(channel: PlotChannel, all: readonly PlotChannel[]): string {
  if (all.length === 1) return labelOf(channel);
  if (channel.name !== "" && all.every(({ group }) => group === channel.group)) return channel.name;
  if (all.every(({ name }) => name === channel.name)) return channel.group;
  return labelOf(channel);
}

function titleOf(found: readonly PlotChannel[]): string {
  if (found.length === 1) return labelOf(found[0]);
  return found.length === 0 ? "nothing chosen" : [...new Set(found.map(({ group }) => group))].join(", ");
}

function isMagnitude({ unit, index, field }: PlotChannel): boolean {
  return index === null || NEVER_NEGATIVE.has(unit) || field === "residual";
}
