import type { Field } from "../api/types";

/** The page and the server disagree about a record. */
export class LayoutError extends Error {}

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
