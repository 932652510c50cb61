/** Which stretch of time the plots show: pause, zoom and pan as pure functions. Times [s] on the rig's clock. */
export interface Range {
  readonly from: number;
  readonly to: number;
}

export interface View {
  /** Newest time when the picture was stopped; null while it follows the rig. */
  readonly stoppedAt: number | null;
  /** The picture was stopped by zooming, so that resetting the zoom lets it follow again. */
  readonly byZoom: boolean;
  readonly zoom: Range | null;
}

/** What a hand wants of the time axis; times [s on the rig's clock]. */
export type Gesture =
  | { readonly kind: "zoom"; readonly from: number; readonly to: number }
  | { readonly kind: "scale"; readonly factor: number; readonly about: number }
  | { readonly kind: "move"; readonly seconds: number }
  | { readonly kind: "hold"; readonly held: boolean }
  | { readonly kind: "whole" };

/** The newest time there is, and the length of the window without a zoom [s]. */
export interface Now {
  readonly newest: number;
  readonly seconds: number;
}

export const FOLLOWING: View = { stoppedAt: null, byZoom: false, zoom: null };
export const SPAN_MIN_S = 0.05;
export const SPAN_MAX_S = 600;

export function visible(view: View, now: Now): Range {
  const to = view.stoppedAt ?? now.newest;
  return view.zoom ?? { from: to - now.seconds, to };
}

/** What is shown, counted from where it stopped, else from the newest: it then stands still while the picture runs. */
export function counted(view: View, seconds: number): Range {
  const origin = view.stoppedAt ?? 0;
  const { from, to } = visible(view, { newest: origin, seconds });
  return { from: from - origin, to: to - origin };
}

export function paused(now: Now): View {
  return { ...FOLLOWING, stoppedAt: now.newest };
}

/** Stop the picture at a range of it; one that is too short for the eye is not taken. */
export function zoomed(view: View, range: Range, now: Now): View {
  if (!(range.to - range.from >= SPAN_MIN_S)) return view;
  const byZoom = view.stoppedAt === null || view.byZoom;
  return { zoom: range, stoppedAt: view.stoppedAt ?? now.newest, byZoom };
}

/** Show `factor` times as long a time; what is at `about` stays where it is. */
export function scaled(view: View, factor: number, about: number, now: Now): View {
  const { from, to } = visible(view, now);
  const wanted = Math.min(SPAN_MAX_S, Math.max(SPAN_MIN_S, (to - from) * factor));
  const real = wanted / (to - from);
  return zoomed(view, { from: about - (about - from) * real, to: about + (to - about) * real }, now);
}

/** Show the time `seconds` later. */
export function moved(view: View, seconds: number, now: Now): View {
  const { from, to } = visible(view, now);
  return zoomed(view, { from: from + seconds, to: to + seconds }, now);
}

/** Without the zoom: where the pause was, or following again. */
export function whole(view: View): View {
  return { zoom: null, stoppedAt: view.byZoom ? null : view.stoppedAt, byZoom: false };
}
