import { Refusal, refusalText, Unreachable } from "../api/rest";
import type { PlotChannel } from "../api/types";
import type { Ring } from "../live/ring";
import type { Range } from "./chart/view";

/** The browser may still be reading the file. */
const RELEASE_AFTER_MS = 10_000;

/** The server's CSV of these channels (keys) in a range; every tick of the last minute, else 16 ms extremes. */
export function csvUrl(keys: readonly string[], { from, to }: Range): string {
  const query = new URLSearchParams({ from: String(from), to: String(to) });
  for (const key of keys) query.append("channels", key);
  return `/api/history.csv?${query.toString()}`;
}

/** The same from the bins that this page holds: for when the server no longer has them. SI units. */
export function csvOfBins(
  ring: Ring,
  channels: readonly PlotChannel[],
  places: readonly number[],
  range: Range,
): string {
  const labels = places.map((place) => `${channels[place].key} [${channels[place].unit}]`);
  const lines = [
    "# from the page: the server could not be asked, or keeps nothing of this time; t is the rig's clock",
    "# lowest and highest value of 16 ticks in each line, t in their middle",
    ["t [s]", ...labels.flatMap((label) => [`${label} low`, `${label} high`])].join(","),
  ];
  const end = ring.indexAt(range.to);
  for (let bin = ring.indexAt(range.from); bin < end; bin++) {
    const cells = places.flatMap((place) => ring.extremes(place, bin, bin + 1));
    lines.push([ring.time(bin).toFixed(4), ...cells.map(cell)].join(","));
  }
  return lines.join("\n") + "\n";
}

/** The server's answer; null where it has nothing of that time, or cannot be reached. */
export async function askForCsv(url: string): Promise<Blob | null> {
  try {
    const response = await fetch(url, { credentials: "same-origin" });
    if (response.ok) return await response.blob();
    if (response.status === 404 || response.status === 503) return null;
    const body: unknown = await response.json().catch(() => null);
    throw new Refusal(response.status, refusalText(body, response.statusText), false);
  } catch (error) {
    if (error instanceof TypeError || error instanceof Unreachable) return null;
    throw error;
  }
}

/** Give the user a file. */
export function download(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), RELEASE_AFTER_MS);
}

function cell(value: number): string {
  return Number.isFinite(value) ? String(Number(value.toPrecision(7))) : "nan";
}
