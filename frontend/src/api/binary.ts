import { LayoutError } from "../rig/record";

/** First word of a binary message (server/messages.py, `Kind`). */
const KIND = { FRAME: 1, PLOT: 2 } as const;
const HEADER = 8;
const PLOT_HEADER = 16;

/** Extremes of every 1 kHz sample in the bins `first`, `first` + 1, ...: `low` and `high` are [bin][channel]. */
export interface PlotBins {
  readonly first: number;
  /** Places of the channels in `Hello.channels`. */
  readonly channels: Uint32Array;
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
      return { kind: "plot", bins: plotBins(buffer) };
    default:
      throw new LayoutError(`unknown kind ${kind} of binary message`);
  }
}

function plotBins(buffer: ArrayBuffer): PlotBins {
  const [, count, width, first] =
    buffer.byteLength < PLOT_HEADER ? [0, NaN, NaN, 0] : new Uint32Array(buffer, 0, 4);
  const channels = PLOT_HEADER + 8 * count;
  const low = channels + 4 * width;
  const samples = count * width;
  if (buffer.byteLength !== low + 8 * samples)
    throw new LayoutError(
      `a plot message of ${buffer.byteLength} bytes does not fit ${count} bins of ${width} channels`,
    );
  return {
    first,
    channels: new Uint32Array(buffer, channels, width),
    t: new Float64Array(buffer, PLOT_HEADER, count),
    low: new Float32Array(buffer, low, samples),
    high: new Float32Array(buffer, low + 4 * samples, samples),
  };
}
