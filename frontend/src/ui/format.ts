/** Numbers for people: SI in, display unit out, a dash for what is missing. */
export const DASH = "–";

type Value = number | null | undefined;

/** `value` with a fixed number of digits; never "-0". */
export function plain(value: Value, digits: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return DASH;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

function fixed(value: Value, scale: number, digits: number, unit: string): string {
  const text = plain(typeof value === "number" ? value * scale : value, digits);
  return text === DASH || unit === "" ? text : `${text} ${unit}`;
}

export const millimetres = (metres: Value, digits = 1) => fixed(metres, 1e3, digits, "mm");
export const kilopascals = (pascals: Value) => fixed(pascals, 1e-3, 0, "kPa");
export const milliseconds = (seconds: Value, digits = 1) => fixed(seconds, 1e3, digits, "ms");
export const microseconds = (nanoseconds: Value) => fixed(nanoseconds, 1e-3, 1, "µs");
export const percent = (share: Value, digits = 2) => fixed(share, 100, digits, "%");
export const wholeNumber = (value: Value) => fixed(value, 1, 0, "");
export const millimetresPerSecond = (speed: Value) => fixed(speed, 1e3, Number(speed) < 0.1 ? 1 : 0, "mm/s");
export const metresPerSquareSecond = (acceleration: Value) => fixed(acceleration, 1, 2, "m/s²");
export const degrees = (angle: Value) => fixed(angle, 1, 1, "°");
export const hertz = (frequency: Value) => fixed(frequency, 1, 2, "Hz");
export const seconds = (value: Value, digits = 0) => fixed(value, 1, digits, "s");

/** Gains of the reference's velocity, in x and y: one where they are the same. */
export function velocityGain([x, y]: readonly [number, number]): string {
  return x === y ? seconds(x, 3) : `${plain(x, 3)}, ${seconds(y, 3)}`;
}

/** A display value without the dust of binary fractions. */
export function rounded(value: number): number {
  return Number(value.toPrecision(10));
}

/** Duration as 1:02:03 or 2:03. */
export function clock(duration: number): string {
  const whole = Math.max(0, Math.floor(duration));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const two = (n: number) => String(n).padStart(2, "0");
  return h > 0 ? `${h}:${two(m)}:${two(s)}` : `${m}:${two(s)}`;
}

/** Size with a decimal prefix. */
export function bytes(size: number): string {
  if (size >= 1e9) return `${(size / 1e9).toFixed(2)} GB`;
  if (size >= 1e6) return `${(size / 1e6).toFixed(1)} MB`;
  return `${(size / 1e3).toFixed(0)} kB`;
}

// Made once: making one takes longer than many of its answers.
const LOCAL = new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "medium" });
const DATE = new Intl.DateTimeFormat(undefined, { dateStyle: "medium" });
const OF_DAY = new Intl.DateTimeFormat(undefined, { timeStyle: "medium", hour12: false });

/** Local date and time of an ISO time stamp. */
export function localTime(iso: string): string {
  return LOCAL.format(new Date(iso));
}

/** Local date of an ISO time stamp. */
export function localDate(iso: string): string {
  return DATE.format(new Date(iso));
}

/** Local time of day of an ISO time stamp. */
export function timeOfDay(iso: string): string {
  return OF_DAY.format(new Date(iso));
}

export function textOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
