import { useComputedColorScheme } from "@mantine/core";
import { useElementSize, useMergedRef } from "@mantine/hooks";
import { useEffect, useImperativeHandle, useRef, type Ref } from "react";
import type { Point } from "../../api/types";
import { disc, polyline, resize, sheetOf } from "../../plan/paint/canvas";
import { paintPaper } from "../../plan/paint/paper";
import { boundingBox, fit } from "../../plan/transform";
import { INK } from "../../ui/colours";
import { nearest } from "./quickCharts";

/** A path in the plane [m] over time [s]. */
export interface DrawnPath {
  readonly label: string;
  readonly colour: string;
  readonly dash: readonly number[];
  readonly width: number;
  readonly t: readonly number[];
  readonly points: readonly (Point | null)[];
  /** First point that is drawn, and the one after the last: dashes of several laps would fill each other's gaps. */
  readonly part: readonly [number, number];
}

/** Lets the plots' cursor be shown on the path without React. */
export interface PathMark {
  /** Mark where each path is at time `t` [s]; null for nowhere. */
  readonly show: (t: number | null) => void;
}

interface Props {
  readonly paths: readonly DrawnPath[];
  readonly mark: Ref<PathMark>;
}

const MARGIN = 28;
const SPAN_MIN = 0.01;

/** The paths in the plane, to scale, as large as they go. */
export function PathCanvas({ paths, mark }: Props) {
  const { ref: sized, width, height } = useElementSize<HTMLCanvasElement>();
  const marked = useRef<number | null>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const both = useMergedRef(sized, canvas);
  const ink = INK[useComputedColorScheme("dark")];
  const paint = (at: number | null) => {
    marked.current = at;
    const element = canvas.current;
    if (!element || width === 0 || height === 0) return;
    const size = { width, height };
    const box = boundingBox(paths.flatMap(({ points, part }) => points.slice(...part)));
    const g = resize(element, size, devicePixelRatio);
    if (!g) return;
    const middle = box ?? { left: 0, right: 0.2, bottom: -0.1, top: 0.1 };
    const slack = (extent: number) => Math.max(0, SPAN_MIN - extent) / 2;
    const [dx, dy] = [slack(middle.right - middle.left), slack(middle.top - middle.bottom)];
    const wide = { left: middle.left - dx, right: middle.right + dx, bottom: middle.bottom - dy, top: middle.top + dy }; // prettier-ignore
    const sheet = sheetOf(g, fit(wide, size, MARGIN), size, ink);
    paintPaper(sheet, null, devicePixelRatio);
    for (const path of paths) {
      g.strokeStyle = path.colour;
      g.lineWidth = path.width;
      g.setLineDash([...path.dash]);
      for (const part of unbroken(path.points.slice(...path.part))) {
        polyline(sheet, part);
        g.stroke();
      }
    }
    g.setLineDash([]);
    if (at === null) return;
    for (const path of paths) {
      const point = path.points.at(nearest(path.t, at));
      if (!point) continue;
      g.fillStyle = path.colour;
      disc(g, sheet.pixel(point), 5);
      g.fill();
    }
  };
  useImperativeHandle(mark, () => ({ show: paint }));
  useEffect(() => {
    paint(marked.current);
  });
  const named = paths.map(({ label }) => label).join(", ");
  return <canvas ref={both} className="quick-path" role="img" aria-label={`Paths in the plane: ${named}`} data-testid="quick-path" />; // prettier-ignore
}

/** The stretches without a gap. */
function unbroken(points: readonly (Point | null)[]): Point[][] {
  const parts: Point[][] = [[]];
  for (const point of points) {
    if (point) parts.at(-1)?.push(point);
    else if (parts.at(-1)?.length) parts.push([]);
  }
  return parts;
}
