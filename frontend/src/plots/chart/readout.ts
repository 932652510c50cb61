import type { Chart } from "./charts";

/** A line's values around the cursor, in text; and where the cursor is. */
export interface Reading {
  readonly values: readonly string[];
  /** Show it on the left: the cursor is in the right half. */
  readonly left: boolean;
}

/** The box that follows the cursor: every line of the chart with its value, in the title's unit. Written without React. */
export class Readout {
  private readonly box = document.createElement("div");
  private readonly values: HTMLElement[];

  constructor(chart: Chart, host: HTMLElement) {
    this.box.className = "readout";
    this.box.dataset.testid = "readout";
    this.box.hidden = true;
    const names = withoutCommonStart(chart.lines.map(({ name }) => name));
    this.values = chart.lines.map(({ colour, look }, i) => this.row(names[i], colour, look));
    host.append(this.box);
  }

  hide(): void {
    this.box.hidden = true;
  }

  show(reading: Reading): void {
    this.box.hidden = false;
    this.box.dataset.side = reading.left ? "left" : "right";
    this.values.forEach((element, i) => write(element, reading.values[i]));
  }

  destroy(): void {
    this.box.remove();
  }

  private row(name: string, colour: string, look: string): HTMLElement {
    const [row, swatch, title, value] = ["div", "i", "span", "b"].map((tag) => document.createElement(tag));
    row.className = "readout-row";
    swatch.className = `swatch swatch-${look}`;
    swatch.style.color = colour;
    title.textContent = name;
    value.className = "number";
    row.append(swatch, title, value);
    this.box.append(row);
    return value;
  }
}

/** The time under the pointer, written on every time axis of plots with one cursor. Without React. */
export class TimeCursor {
  private readonly tags = new Set<HTMLElement>();

  /** Keep a tag in its place on an axis; returns how to stop it. */
  add(tag: HTMLElement): () => void {
    tag.hidden = true;
    this.tags.add(tag);
    return () => {
      this.tags.delete(tag);
    };
  }

  /** Show `text` at a share of the axis, from its left end. */
  show(share: number, text: string): void {
    const left = `${(100 * share).toFixed(2)}%`;
    for (const tag of this.tags) {
      tag.hidden = false;
      if (tag.style.left !== left) tag.style.left = left;
      write(tag, text);
    }
  }

  hide(): void {
    for (const tag of this.tags) tag.hidden = true;
  }
}

/** Names without the first words that all have: what a plot's title says of them already. */
export function withoutCommonStart(names: readonly string[]): string[] {
  if (names.length < 2) return [...names];
  const words = names.map((name) => name.split(" "));
  const differ = words[0].findIndex((word, i) => words.some((of) => i === of.length - 1 || of[i] !== word));
  return words.map((of) => of.slice(differ).join(" "));
}

export function write(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}
