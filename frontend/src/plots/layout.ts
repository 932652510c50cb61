import type { Plot, PlotLayout } from "../api/types";

/** Where the server keeps what this browser plotted last. */
export const LAST_USED = "last used";
export const PLOTS_MAX = 8;
export const LINES_MAX = 12;
export const SPANS = [5, 10, 30, 60, 120, 300, 600] as const;

const axes = (index: number) => ["p_meas", "p_hat", "p_ref"].map((field) => `${field}.${index}`);
const CHAMBERS = [0, 1, 2, 3].flatMap((chamber) => [`pressure_cmd.${chamber}`, `pressure_meas.${chamber}`]);

export const DEFAULT_LAYOUT: PlotLayout = {
  seconds: 10,
  plots: [
    { title: "x", channels: axes(0) },
    { title: "y", channels: axes(1) },
    { title: "error", channels: ["error.norm"] },
    { title: "pressures", channels: CHAMBERS },
  ],
};

/** Every channel that a layout shows, once. */
export function channelsOf(layout: PlotLayout): string[] {
  return [...new Set(layout.plots.flatMap((plot) => plot.channels))];
}

export function withPlot(layout: PlotLayout): PlotLayout {
  if (layout.plots.length >= PLOTS_MAX) return layout;
  return { ...layout, plots: [...layout.plots, { title: "", channels: [] }] };
}

export function withoutPlot(layout: PlotLayout, index: number): PlotLayout {
  return { ...layout, plots: layout.plots.filter((_, i) => i !== index) };
}

/** Another choice of signals for one plot; a title that was given for the old ones goes. */
export function withSignals(layout: PlotLayout, index: number, channels: readonly string[]): PlotLayout {
  const plot: Plot = { title: "", channels: channels.slice(0, LINES_MAX) };
  return { ...layout, plots: layout.plots.map((old, i) => (i === index ? plot : old)) };
}

/** A name as the server takes it. */
export function layoutName(text: string): string {
  return text
    .trim()
    .replace(/[^\p{L}\p{N}_ .+()-]/gu, "-")
    .slice(0, 40);
}
