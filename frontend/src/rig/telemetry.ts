import { RecordReader, type FieldReader } from "./record";
import type { Field, Point } from "../api/types";

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

export type TelemetryField = (typeof FIELDS)[number];

/** The newest telemetry record, read in place: `telemetry.at("p_ref", 1)`. */
export class Telemetry {
  private readonly record: RecordReader;
  private readonly fields: Record<TelemetryField, FieldReader>;

  constructor(layout: readonly Field[]) {
    const record = new RecordReader(layout);
    this.record = record;
    this.fields = Object.fromEntries(FIELDS.map((name) => [name, record.field(name)])) as Record<
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
