/** The page's colours: painters take them from here, and styles as variables of the same names (`var(--measured)`).
 * One colour per role, the same in the plan, the plots, the 3D view and recordings; shape or dash always goes with it. */
export const ROLE = {
  reference: "#E69F00",
  measured: "#009E73",
  observer: "#56B4E9",
  twin: "#999999",
  ghost: "#CC79A7",
  danger: "#D55E00",
} as const;

/** Bundled with the page; the second is what a browser has while it comes. */
export const FONT = "'Inter Variable', system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

export type Scheme = "dark" | "light";

/** Colours of paper and ink on canvases. */
export interface Ink {
  readonly paper: string;
  readonly text: string;
  readonly soft: string;
  readonly grid: string;
  readonly gridMajor: string;
  readonly reach: string;
  readonly target: string;
}

export const INK: Record<Scheme, Ink> = {
  dark: {
    paper: "#17191d",
    text: "#e6e8ea",
    soft: "#9aa0a6",
    grid: "#1f2226",
    gridMajor: "#2b2f35",
    reach: "rgba(120, 160, 200, 0.22)",
    target: "#ffffff",
  },
  light: {
    paper: "#ffffff",
    text: "#1b1e21",
    soft: "#5c636a",
    grid: "#f0f1f3",
    gridMajor: "#dcdfe3",
    reach: "rgba(60, 110, 170, 0.15)",
    target: "#111111",
  },
};

/** Lines of plots that have no role: told apart by name, too. */
export const LINES = [
  "#A78BFA",
  "#B5A900",
  "#B0805A",
  "#7C93B2",
  "#D884B5",
  "#4FB8A8",
  "#E07B5A",
  "#8FA83C",
] as const;

/** What styles of several parts share beside the roles; two colours are for paper and for the dark. */
const TONES = {
  good: "light-dark(#0b6b4f, #4fd1a5)",
  warning: "light-dark(#8a5a00, #f2b84b)",
  bad: "light-dark(#b02a1a, #ff8a70)",
  soft: `light-dark(${INK.light.soft}, ${INK.dark.soft})`,
  focus: "light-dark(#1864ab, #74c0fc)",
  accent: "light-dark(#1c6fb8, #56b4e9)",
  ground: "light-dark(#e9ecf0, #0e1013)",
  surface: `light-dark(${INK.light.paper}, ${INK.dark.paper})`,
  raised: "light-dark(#e3e8ee, #2a2e34)",
  blue: "#1c6fb8",
  green: "#00805d",
  stop: "#d3222a",
  "stop-edge": "#8f0f16",
  "on-amber": "#1b1200",
};

/** Give the roles and tones to the styles. */
export function publishColours({ style }: HTMLElement): void {
  for (const [name, colour] of Object.entries({ ...ROLE, ...TONES })) style.setProperty(`--${name}`, colour);
}
