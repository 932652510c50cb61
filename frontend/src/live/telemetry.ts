import { LayoutError } from "../api/socket";
import type { Field, Mode, Point } from "../api/types";
import { isMovable } from "./modes";

/** Telemetry fields that the page reads (controller/schema/messages.py, `Telemetry`). */
const FIELDS = [
  "tick",
  "slot",
  "mode",
  "cause",
  "lost",
  "sensed",
  "step_ns",
  "measurement_age",
  "operator_age",
  "server_age",
  "target",
  "p_ref",
  "p_meas",
  "p_hat",
  "error",
  "residual",
  "u",
  "saturated",
  "reachable",
  "pressure_meas",
  "energy",
  "power",
  "ledger",
  "markers",
  "backbone",
  "twin_backbone",
] as const;

/** Names of the chambers, in the order of their pressures (controller/schema/titles.py). */
export const CHAMBERS = ["u1+", "u1-", "u2+", "u2-"] as const;

export type TelemetryField = (typeof FIELDS)[number];

/** The newest telemetry record, read in place: `telemetry.at("p_ref", 1)`. */
export class Telemetry {
  private readonly record: RecordReader;
  private readonly fields: Record<TelemetryField, FieldReader>;

  constructor(layout: readonly Field[]) {
    this.record = new RecordReader(layout);
    this.fields = Object.fromEntries(FIELDS.map((name) => [name, this.record.field(name)])) as Record<
      TelemetryField,
      FieldReader
    >;
  }

  load(buffer: ArrayBuffer, offset: number): void {
    this.record.load(buffer, offset);
  }

  at(name: TelemetryField, index = 0): number {
    return this.fields[name].at(index);
  }

  /** Points in a field of pairs. */
  points(name: TelemetryField): number {
    return this.fields[name].length / 2;
  }

  /** The pair `index` of a field of pairs, or null where it is not finite. */
  point(name: TelemetryField, index = 0): Point | null {
    const [x, y] = [this.at(name, 2 * index), this.at(name, 2 * index + 1)];
    return Number.isFinite(x) && Number.isFinite(y) ? [x, y] : null;
  }

  /** Every field by name, for tests and the console. */
  snapshot(): Record<string, number | number[]> {
    return Object.fromEntries(this.record.names.map((name) => [name, plain(this.record.field(name))]));
  }
}

function plain(field: FieldReader): number | number[] {
  return field.length === 1 ? field.at(0) : Array.from({ length: field.length }, (_, i) => field.at(i));
}

/** Of which tip the rig's `error` is: the loop takes the measured one where the rod at the tip is sensed. */
export type ErrorOf = "measured" | "estimated" | "none";

/** "none" where nothing rules: the reference of a rig that is vented, rests or is latched is no wish. */
export function errorOf(telemetry: Pick<Telemetry, "at" | "points">, mode: Mode | null): ErrorOf {
  if (mode === null || !isMovable(mode)) return "none";
  const tip = 2 ** (telemetry.points("markers") - 1);
  return Math.floor(telemetry.at("sensed") / tip) % 2 === 1 ? "measured" : "estimated";
}

const BYTES = { float64: 8, float32: 4, int64: 8 } as const;
const WORD = 2 ** 32;

/** Reads one field of the record that `RecordReader` holds at the moment. */
export interface FieldReader {
  readonly length: number;
  at(index: number): number;
}

/** A binary record read in place: fields by name, at the offsets that the server's `Hello.layout` gives. */
export class RecordReader {
  private view = new DataView(new ArrayBuffer(0));
  private readonly fields = new Map<string, FieldReader>();
  readonly size: number;

  constructor(layout: readonly Field[]) {
    for (const field of layout) this.fields.set(field.name, this.reader(field));
    this.size = Math.max(0, ...layout.map((field) => field.offset + BYTES[field.type] * count(field)));
  }

  get names(): string[] {
    return [...this.fields.keys()];
  }

  /** Take `buffer` from byte `offset` as the record to read. */
  load(buffer: ArrayBuffer, offset: number): void {
    if (buffer.byteLength - offset < this.size)
      throw new LayoutError(`a record has ${buffer.byteLength - offset} bytes instead of ${this.size}`);
    this.view = new DataView(buffer, offset, this.size);
  }

  field(name: string): FieldReader {
    const found = this.fields.get(name);
    if (!found) throw new LayoutError(`the rig's record has no field "${name}": reload the page`);
    return found;
  }

  private reader({ offset, type, ...field }: Field): FieldReader {
    const length = count(field);
    const empty = (index: number) => this.view.byteLength === 0 || index >= length;
    switch (type) {
      case "float64":
        return { length, at: (i) => (empty(i) ? NaN : this.view.getFloat64(offset + 8 * i, true)) };
      case "float32":
        return { length, at: (i) => (empty(i) ? NaN : this.view.getFloat32(offset + 4 * i, true)) };
      case "int64":
        return { length, at: (i) => (empty(i) ? NaN : this.int64(offset + 8 * i)) };
    }
  }

  /** Exact up to 2^53 (104 days of nanoseconds), without the garbage of a BigInt. */
  private int64(offset: number): number {
    return this.view.getInt32(offset + 4, true) * WORD + this.view.getUint32(offset, true);
  }
}

function count(field: Pick<Field, "shape">): number {
  return field.shape.reduce((product, n) => product * n, 1);
}
