import type { PlotChannel } from "../api/types";
import { ROLE } from "../roles";

/** One line of a chart: which telemetry element, and how it looks. */
export interface Line {
  readonly field: string;
  readonly index: number | null;
  readonly name: string;
  readonly colour: string;
  readonly look: "solid" | "dashed" | "dots" | "thin";
}

export interface Chart {
  readonly title: string;
  readonly unit: string;
  /** From SI to `unit`. */
  readonly scale: number;
  readonly digits: number;
  /** Least height of the y axis [unit]. */
  readonly least: number;
  readonly fromZero: boolean;
  /** Lines carry their name at their end and beside their value, so that colour is not alone. */
  readonly numbered: boolean;
  readonly lines: readonly Line[];
}

const LENGTH = { unit: "mm", scale: 1e3, digits: 1, least: 4, numbered: false } as const;

function position(title: string, index: number): Chart {
  return {
    ...LENGTH,
    title,
    fromZero: false,
    lines: [
      { field: "p_meas", index, name: "measured", colour: ROLE.measured, look: "dots" },
      { field: "p_hat", index, name: "observer", colour: ROLE.observer, look: "solid" },
      { field: "p_ref", index, name: "reference", colour: ROLE.reference, look: "dashed" },
    ],
  };
}

/** Chambers have no role of their own: four more colours, and their number at the end of each line. */
const CHAMBER = ["#A78BFA", "#B5A900", "#B0805A", "#7C93B2"] as const;

const PRESSURES: readonly Line[] = CHAMBER.flatMap((colour, index): Line[] => [
  { field: "pressure_cmd", index, name: `${index + 1} commanded`, colour, look: "thin" },
  { field: "pressure_meas", index, name: String(index + 1), colour, look: "solid" },
]);

export const CHARTS: readonly Chart[] = [
  position("x", 0),
  position("y", 1),
  {
    ...LENGTH,
    title: "error",
    fromZero: true,
    lines: [{ field: "error", index: null, name: "|e|", colour: "#8b95a1", look: "solid" }],
  },
  {
    title: "pressures",
    unit: "kPa",
    scale: 1e-3,
    digits: 0,
    least: 20,
    fromZero: true,
    numbered: true,
    lines: PRESSURES,
  },
];

/** Column of every line in the server's plot bins; -1 where the server does not send it. */
export function columnsOf(chart: Chart, channels: readonly PlotChannel[]): number[] {
  return chart.lines.map((line) =>
    channels.findIndex((channel) => channel.field === line.field && channel.index === line.index),
  );
}
