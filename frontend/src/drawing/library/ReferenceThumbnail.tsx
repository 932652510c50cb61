import { useMemo } from "react";
import { usePage } from "../../live/page";
import { chosenInfo } from "./references";
import { plannedLines, thumbnailPath } from "./shown";

const [WIDTH, HEIGHT] = [44, 28];
/** Room for the line's own width. */
const MARGIN = 3;

/** A small picture of the chosen reference; its place is kept while there is none. */
export function ReferenceThumbnail() {
  const info = usePage(chosenInfo);
  const reference = usePage((page) => page.reference);
  const path = useMemo(() => {
    const shape = reference ? plannedLines(reference, info?.frequency ?? null).shape : [];
    return thumbnailPath(shape, WIDTH - 2 * MARGIN, HEIGHT - 2 * MARGIN);
  }, [reference, info]);
  const named =
    path === "" || !info ? { "aria-hidden": true } : { role: "img", "aria-label": `Shape of ${info.title}` };
  return (
    <svg className="thumbnail" width={WIDTH} height={HEIGHT} data-testid="thumbnail" {...named}>
      <path d={path} transform={`translate(${MARGIN} ${MARGIN})`} />
    </svg>
  );
}
