import type { Point } from "../../api/types";
import { boxOf } from "./proposal";

interface Props {
  readonly strokes: readonly (readonly Point[])[];
}

/** The strokes to scale, as large as they go; a dot is where the path begins, thin lines are the ways between strokes. */
export function PathPicture({ strokes }: Props) {
  const { left, right, bottom, top } = boxOf(strokes);
  const size = Math.max(right - left, top - bottom);
  const margin = size * 0.06;
  const [width, height] = [right - left + 2 * margin, top - bottom + 2 * margin];
  const pixel = ([x, y]: Point) => `${(x - left + margin) / size},${(top - y + margin) / size}`;
  const ways = strokes.slice(1).map((stroke, i) => [strokes[i].at(-1) ?? stroke[0], stroke[0]]);
  const [x, y] = pixel(strokes[0][0]).split(",");
  return (
    <svg
      className="import-picture"
      data-testid="import-picture"
      viewBox={`0 0 ${width / size} ${height / size}`}
      role="img"
      aria-label="The path; the dot is where it begins"
    >
      {ways.map((way, i) => (
        <polyline key={i} className="import-way" points={way.map(pixel).join(" ")} />
      ))}
      {strokes.map((stroke, i) => (
        <polyline key={i} className="import-stroke" points={stroke.map(pixel).join(" ")} />
      ))}
      <circle className="import-start" cx={x} cy={y} r={0.014} />
    </svg>
  );
}
