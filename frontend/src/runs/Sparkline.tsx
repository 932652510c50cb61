import { errorText } from "./facts";

const WIDTH = 160;
const HEIGHT = 30;

/** The error over a run [m], from 0 to its largest; where the tip was not seen the line is broken. */
export function Sparkline({ errors }: { readonly errors: readonly (number | null)[] }) {
  const most = Math.max(...errors.map((error) => error ?? 0));
  if (errors.length < 2 || most <= 0) return null;
  return (
    <svg
      className="sparkline"
      viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
      preserveAspectRatio="none"
      role="img"
      aria-label={`Error over the run, at most ${errorText(most)}`}
      data-testid="run-sparkline"
    >
      <title>{`Error over the run: bottom 0, top ${errorText(most)}`}</title>
      <path d={linesOf(errors, most)} />
    </svg>
  );
}

function linesOf(errors: readonly (number | null)[], most: number): string {
  const step = WIDTH / (errors.length - 1);
  const point = (error: number, i: number) =>
    `${(i * step).toFixed(1)} ${((1 - error / most) * (HEIGHT - 2) + 1).toFixed(1)}`;
  return errors
    .map((error, i) =>
      error === null ? "" : `${i > 0 && errors[i - 1] !== null ? "L" : "M"}${point(error, i)}`,
    )
    .join("");
}
