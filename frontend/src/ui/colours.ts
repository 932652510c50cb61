/** One colour per role, the same in the plan, the plots, the 3D view and recordings; shape or dash always goes with it. */
export const ROLE = {
  reference: "#E69F00",
  measured: "#009E73",
  observer: "#56B4E9",
  twin: "#999999",
  ghost: "#CC79A7",
  danger: "#D55E00",
} as const;

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
    paper: "#16181b",
    text: "#e6e8ea",
    soft: "#9aa0a6",
    grid: "#222529",
    gridMajor: "#30353a",
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
