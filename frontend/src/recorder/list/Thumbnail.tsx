/** The recording's path, small; nothing where there is none. Its data are the server's, in a box of 100 x 100. */
export function Thumbnail({ path }: { readonly path: string | null }) {
  return (
    <svg className="review-thumbnail" viewBox="-6 -6 112 112" width={44} height={26} aria-hidden>
      {path ? <path d={path} vectorEffect="non-scaling-stroke" /> : null}
    </svg>
  );
}
