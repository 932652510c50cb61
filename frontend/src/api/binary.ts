import { LayoutError } from "./record";

/** First word of a binary message (server/messages.py, `Kind`). */
const KIND = { FRAME: 1, PLOT: 2 } as const;
const HEADER = 8;

/** Extremes of every 1 kHz sample per time bin: `low` and `high` are [bin][channel]. */
export interface PlotBins {
  readonly t: Float64Array;
  readonly low: Float32Array;
  readonly high: Float32Array;
}

export type Binary = { kind: "frame"; offset: number } | { kind: "plot"; bins: PlotBins };

/** Say what a binary message holds; plot bins are views into `buffer`, nothing is copied. */
export function decodeBinary(buffer: ArrayBuffer): Binary {
  if (buffer.byteLength < HEADER)
    throw new LayoutError(`a binary message of ${buffer.byteLength} bytes has no header`);
  const head = new DataView(buffer, 0, HEADER);
  const kind = head.getUint32(0, true);
  switch (kind) {
    case KIND.FRAME:
      return { kind: "frame", offset: HEADER };
    case KIND.PLOT:
      return { kind: "plot", bins: plotBins(buffer, head.getUint32(4, true)) };
    default:
      throw new LayoutError(`unknown kind ${kind} of binary message`);
  }
}

function plotBins(buffer: ArrayBuffer, count: number): PlotBins {
  const samples = (buffer.byteLength - HEADER - 8 * count) / 8;
  if (samples < 0 || (count > 0 && samples % count !== 0))
    throw new LayoutError(`a plot message of ${buffer.byteLength} bytes does not fit ${count} bins`);
  const low = HEADER + 8 * count;
  return {
    t: new Float64Array(buffer, HEADER, count),
    low: new Float32Array(buffer, low, samples),
    high: new Float32Array(buffer, low + 4 * samples, samples),
  };
}
