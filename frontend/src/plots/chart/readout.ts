import type { Chart } from "./charts";

/** A line's values around the cursor, in text; and where the cursor is. */
export interface Reading {
  readonly time: string;
  readonly values: readonly string[];
  /** Show it on the left: the cursor is in the right half. */
  readonly left: boolean;
}

/** The box that follows the cursor: every line of the chart with its value. Written without React. */
export class Readout {
  private readonly box = document.createElement("div");
  private readonly time = document.createElement("div");
  private readonly values: HTMLElement[];

  constructor(chart: Chart, host: HTMLElement) {
    this.box.className = "readout";
    this.box.dataset.testid = "readout";
    this.box.hidden = true;
    this.time.className = "readout-time number";
    this.box.append(this.time);
    this.values = chart.lines.map((line) => this.row(line.name, line.colour, line.look, chart.unit));
    host.append(this.box);
  }

  hide(): void {
    this.box.hidden = true;
  }

  show(reading: Reading): void {
    this.box.hidden = false;
    this.box.dataset.side = reading.left ? "left" : "right";
    write(this.time, reading.time);
    this.values.forEach((element, i) => {
      write(element, reading.values[i]);
    });
  }

  destroy(): void {
    this.box.remove();
  }

  private row(name: string, colour: string, look: string, unit: string): HTMLElement {
    const [row, swatch, title, value, suffix] = ["div", "i", "span", "b", "span"].map((tag) =>
      document.createElement(tag),
    );
    row.className = "readout-row";
    swatch.className = `swatch swatch-${look}`;
    swatch.style.color = colour;
    title.textContent = name;
    value.className = "number";
    suffix.className = "unit";
    suffix.textContent = unit;
    row.append(swatch, title, value, suffix);
    this.box.append(row);
    return value;
  }
}

export function write(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}
