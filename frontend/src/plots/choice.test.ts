import { expect, test } from "vitest";
import type { PlotChannel } from "../api/types";
import { Ring } from "../live/ring";
import { chartOf } from "./chart/charts";
import { FOLLOWING, moved, paused, scaled, visible, whole, zoomed } from "./chart/view";
import { csvOfBins, csvUrl } from "./csv";
import { displayOf, labelOf, matches, menuOf } from "./signals";
import { channelsOf, DEFAULT_LAYOUT, LINES_MAX, layoutName, PLOTS_MAX, withoutPlot, withPlot, withSignals } from "./layout"; // prettier-ignore

const channel = (key: string, group: string, name: string, unit: string): PlotChannel => {
  const [field, index] = key.split(".");
  return { key, group, name, unit, field, index: index === "norm" ? null : Number(index || 0) };
};
const CHANNELS = [
  channel("p_ref.0", "reference", "x", "m"),
  channel("p_ref.1", "reference", "y", "m"),
  channel("p_hat.0", "observer tip", "x", "m"),
  channel("p_hat.1", "observer tip", "y", "m"),
  channel("p_meas.0", "measured tip", "x", "m"),
  channel("p_meas.1", "measured tip", "y", "m"),
  channel("error.norm", "error", "norm", "m"),
  channel("pressure_cmd.0", "pressure command", "1", "Pa"),
  channel("pressure_meas.0", "pressure", "1", "Pa"),
  channel("pressure_meas.1", "pressure", "2", "Pa"),
  channel("energy", "energy", "", "J"),
];
const chart = (...keys: string[]) => chartOf({ title: "", channels: keys }, CHANNELS);

test("a signal has its role's look, a second one of that role another colour and its name", () => {
  const [reference, observer, other] = chart("p_ref.0", "p_hat.0", "p_hat.1").lines;
  expect([reference.look, reference.colour, reference.named]).toEqual(["dashed", "#E69F00", false]);
  expect([observer.look, observer.colour]).toEqual(["solid", "#56B4E9"]);
  expect(other.colour).not.toBe(observer.colour);
  expect([other.named, other.name]).toEqual([true, "observer tip y"]);
});

test("a pressure and its command have one colour, thin for the command", () => {
  const [command, first, second] = chart("pressure_cmd.0", "pressure_meas.0", "pressure_meas.1").lines;
  expect([command.colour, command.look]).toEqual([first.colour, "thin"]);
  expect(second.colour).not.toBe(first.colour);
});

test("a plot is in display units, named by its signals, and leaves out what it cannot show", () => {
  expect(chart("energy")).toMatchObject({ title: "energy", unit: "mJ", scale: 1e3, fromZero: false });
  expect(chart("error.norm")).toMatchObject({ title: "|error|", fromZero: true });
  expect(chart("p_ref.0", "energy", "no.such").lines.map((line) => line.key)).toEqual(["p_ref.0"]);
  expect(chart("p_ref.0", "p_ref.1")).toMatchObject({
    title: "reference",
    lines: [{ name: "x" }, { name: "y" }],
  });
  expect(chart()).toMatchObject({ title: "nothing chosen", lines: [] });
  expect(displayOf("1").unit).toBe("");
});

test("the menu groups signals by field and offers only the plot's unit", () => {
  const menu = menuOf(CHANNELS, "Pa");
  expect(menu.map(({ group }) => group)).toContain("pressure [kPa]");
  const offered = menu.flatMap(({ items }) => items).filter(({ disabled }) => !disabled);
  expect(offered.map(({ value }) => value)).toEqual(["pressure_cmd.0", "pressure_meas.0", "pressure_meas.1"]);
  expect(CHANNELS.slice(6, 8).map(labelOf)).toEqual(["|error|", "pressure command 1"]);
  expect([matches("pressure command 2", "PRES 2"), matches("pressure command 2", "pres 3")]).toEqual([
    true,
    false,
  ]);
});

test("a layout changes plot by plot within its bounds", () => {
  expect(channelsOf(DEFAULT_LAYOUT)).toHaveLength(15);
  const more = Array.from({ length: 9 }).reduce<typeof DEFAULT_LAYOUT>(
    (layout) => withPlot(layout),
    DEFAULT_LAYOUT,
  );
  expect(more.plots).toHaveLength(PLOTS_MAX);
  const chosen = withSignals(
    DEFAULT_LAYOUT,
    2,
    Array.from({ length: 20 }, (_, i) => `markers.${i}`),
  );
  expect(chosen.plots[2]).toMatchObject({ title: "", channels: { length: LINES_MAX } });
  expect(withoutPlot(DEFAULT_LAYOUT, 1).plots.map(({ title }) => title)).toEqual(["x", "error", "pressures"]);
  expect(layoutName(" Tür/1; a ")).toBe("Tür-1- a");
});

const NOW = { newest: 100, seconds: 10 };

test("the window follows the rig until it is paused, and values stay where they were", () => {
  expect(visible(FOLLOWING, NOW)).toEqual({ from: 90, to: 100 });
  expect(visible(paused(NOW), { newest: 130, seconds: 10 })).toEqual({ from: 90, to: 100 });
});

test("zooming stops the picture, and resetting lets it go on only if it went on before", () => {
  const zoom = zoomed(FOLLOWING, { from: 92, to: 93 }, NOW);
  expect(visible(zoom, { newest: 200, seconds: 10 })).toEqual({ from: 92, to: 93 });
  expect(whole(zoom)).toEqual(FOLLOWING);
  const stopped = paused(NOW);
  expect(whole(zoomed(stopped, { from: 92, to: 93 }, NOW))).toEqual(stopped);
  expect(zoomed(FOLLOWING, { from: 92, to: 92.01 }, NOW)).toBe(FOLLOWING);
});

test("the wheel keeps the time under the pointer, within bounds, and moves sideways", () => {
  expect(visible(scaled(FOLLOWING, 0.5, 95, NOW), NOW)).toEqual({ from: 92.5, to: 97.5 });
  const widest = visible(scaled(FOLLOWING, 1e6, 95, NOW), NOW);
  expect(widest.to - widest.from).toBeCloseTo(600);
  expect(visible(moved(FOLLOWING, -5, NOW), NOW)).toEqual({ from: 85, to: 95 });
});

test("the CSV of the page says where it comes from and has lows and highs of the visible bins", () => {
  const ring = new Ring(10);
  ring.choose([0, 10]);
  ring.push({
    first: 0,
    channels: Uint32Array.of(0, 10),
    t: Float64Array.of(1, 2, 3),
    low: Float32Array.of(0.1, 1, 0.2, 2, 0.3, NaN),
    high: Float32Array.of(0.5, 1, 0.6, 2, 0.7, NaN),
  });
  const lines = csvOfBins(ring, CHANNELS, [0, 10], { from: 2, to: 4 }).trim().split("\n");
  expect(lines[0]).toContain("# from the page");
  expect(lines[2]).toBe("t [s],p_ref.0 [m] low,p_ref.0 [m] high,energy [J] low,energy [J] high");
  expect(lines.slice(3)).toEqual(["2.0000,0.2,0.6,2,2", "3.0000,0.3,0.7,nan,nan"]);
  expect(csvUrl(["a.0", "b"], { from: 1, to: 2.5 })).toBe(
    "/api/history.csv?from=1&to=2.5&channels=a.0&channels=b",
  );
});

test("a plot of the error says of which tip it is, and that there is none without a reference", () => {
  const plot = { title: "error", channels: ["error.norm"] };
  const titles = (["measured", "estimated", "none"] as const).map((of) => chartOf(plot, CHANNELS, of).title);
  expect(titles).toEqual(["error, measured tip", "error, estimated tip", "error, no reference"]);
  expect(chartOf({ ...plot, channels: ["p_ref.0"] }, CHANNELS, "measured").title).toBe("error");
});
