import type { Quick } from "../../api/types";
import { ROLE } from "../../ui/colours";
import type { DrawnPath } from "./PathCanvas";
import { runRows } from "./course";
import { RUN_STYLES, type Compared } from "./quickCharts";

const LOOKS: Partial<Record<string, Pick<DrawnPath, "label" | "colour" | "dash" | "width">>> = {
  p_ref: { label: "reference", colour: ROLE.reference, dash: [7, 4], width: 2 },
  p_hat: { label: "observer", colour: ROLE.observer, dash: [], width: 1 },
  p_meas: { label: "measured", colour: ROLE.measured, dash: [2, 2], width: 2 },
};

/** The tip's paths of one recording, in the colours of the plan. */
export function pathsOf(quick: Quick): DrawnPath[] {
  return quick.tracks.flatMap((track) => {
    const look = LOOKS[track.field];
    const part = track.field === "p_ref" ? lastLap(quick) : WHOLE;
    return look ? [{ ...look, t: quick.track_t, points: pointsOf(track), part }] : [];
  });
}

/** The measured path of each run on its own clock, and the reference of the first one below them. */
export function comparedPaths(runs: readonly Compared[]): DrawnPath[] {
  const reference = runs.slice(0, 1).flatMap(({ quick }) => runPath(quick, "p_ref"));
  const measured = runs.flatMap(({ quick }, i) => {
    const { colour, dash } = RUN_STYLES[i];
    return runPath(quick, "p_meas").map((path) => ({ ...path, label: `recording ${i + 1}`, colour, dash }));
  });
  return [...reference.map((path) => ({ ...path, width: 1, colour: ROLE.twin })), ...measured];
}

/** A track while the run was followed, of a periodic one its last lap; none where the recording does not hold it. */
function runPath(quick: Quick, field: "p_ref" | "p_meas"): DrawnPath[] {
  const track = quick.tracks.find((one) => one.field === field);
  const look = LOOKS[field];
  if (!track || !look) return [];
  const { places, t } = runRows(quick.track_t, quick.stretches);
  const points = pointsOf(track);
  const lap = lastLap(quick);
  const part = [
    places.findIndex((place) => place >= lap[0]),
    places.filter((place) => place < lap[1]).length,
  ] as const;
  return [
    { ...look, t, points: places.map((place) => points[place]), part: [Math.max(0, part[0]), part[1]] },
  ];
}

const WHOLE = [0, Infinity] as const;

/** The points of the last whole period; all of them where nothing repeats. */
function lastLap({ track_t, period, cycle_end }: Quick): DrawnPath["part"] {
  if (period === null) return WHOLE;
  const after = track_t.findIndex((t) => t > cycle_end);
  const first = track_t.findIndex((t) => t >= cycle_end - period);
  return [Math.max(0, first), after < 0 ? Infinity : after];
}

function pointsOf({ x, y }: Quick["tracks"][number]): DrawnPath["points"] {
  return x.map((value, i) => {
    const other = y[i];
    return value === null || other === null ? null : [value, other];
  });
}
