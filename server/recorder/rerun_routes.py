"""rerun's own web viewer, from our origin, and what we change in its page.

It asks with our cookie, tells of Esc, starts sooner, waits behind.
"""

import re
from importlib.metadata import version
from pathlib import Path

from fastapi import APIRouter, Request, Response
from starlette.responses import FileResponse, PlainTextResponse

from controller.system.whole_file import is_regular
from recordings.read.viewer import FILES
from server.http.frames import SEND_COOKIE, TELL_ESCAPE, TELL_TOUCHED
from server.recorder.review import GivenReview

router = APIRouter(include_in_schema=False)

TYPES = {".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm", ".ico": "image/x-icon"}
FOR_GOOD = "private, max-age=31536000, immutable"
VERSION = version("rerun-sdk")

QUIET = b"""<script>console.debug = () => {};</script>"""
"""The viewer tells there of every shader that it compiles: thousands of lines, seconds of the first frame."""

STAY_HERE = b"""<script>
const ourFetch = fetch;
fetch = (request, options) =>
  ["http:", "https:"].includes(new URL(request.url ?? request, location).protocol) &&
  new URL(request.url ?? request, location).origin !== location.origin
    ? Promise.resolve(new Response(null, { status: 204 }))  // nothing is asked of other servers
    : ourFetch(request, options);
</script>"""
"""The viewer reports home and looks for news; our policy forbids that, and each try would stand in the console."""

OPEN_WHEN_TOLD = b"""<script>
const plainFocus = HTMLElement.prototype.focus;
let behind = !new URLSearchParams(location.search).has("url");
HTMLElement.prototype.focus = function (options) {
  if (!behind) plainFocus.call(this, options);
};
addEventListener("message", ({ origin, data }) => {
  if (origin !== location.origin) return;
  if (data.tendril === "seek") seek(data.seconds);
  if (data.tendril !== "open") return;
  behind = false;
  _handle.add_receiver(data.url);
  _handle.override_panel_state("top");
});
const varint = (value) => (value < 128n ? [Number(value)] : [Number(value & 127n) | 128, ...varint(value >> 7n)]);
const part = (field, bytes) => [field << 3 | 2, bytes.length, ...bytes];
let hand = new AbortController();
async function seek(seconds) {
  const time = varint(BigInt(Math.round(seconds * 1e9)));
  const cursor = part(6, [...part(2, part(1, [116])), ...part(3, [8, ...time])]);  // SetTimeCursorRequest, timeline "t"
  const ask = (bytes) => _handle.viewer_control(new Uint8Array(bytes)).catch(() => null);
  const stands = async () => `${await ask([26, 0])}`.includes(`${time}`);  // GetViewerState
  const draw = setInterval(() => _handle.override_panel_state("top"), 100), end = performance.now() + 60_000;
  hand.abort();
  const mine = hand = new AbortController();
  for (const by of ["pointerdown", "keydown", "wheel"])
    addEventListener(by, () => mine.abort(), { capture: true, signal: mine.signal });
  for (let looks = 0; looks < 15 && !mine.signal.aborted && performance.now() < end; ) {
    await new Promise((then) => setTimeout(then, 200));
    if (await stands()) looks += 1;
    else if (!mine.signal.aborted) looks = (await ask(cursor), 0);
  }
  clearInterval(draw);
}
</script>"""
"""So a viewer can start behind something else. It takes the focus as it starts: one who writes there, or has a finger
on the key for HOLD, must keep it. `_handle` is there before rerun's page says READY. A viewer at rest finds what was
added with its next frame only; to override nothing makes it draw one. The cursor is put where the run begins by
rerun's own control of its viewer (viewer_control.proto), which takes nothing while no recording is there, and may
forget it while the rest of one still comes: so it is put again until it has stood for 3 s, unless a hand moves it;
frames are drawn meanwhile."""

CHANGES = (
    (b"delete WebAssembly.instantiateStreaming;", b""),
    (
        b"        wasm_with_progress();\n      }",
        b"""        wasm_bindgen({ module_or_path: fetch("./re_viewer_bg.wasm?v=VERSION") })
          .then(() => (clearTimeout(timeoutId), on_wasm_loaded()))
          .catch(on_wasm_error);
      }""",
    ),
    (b'src="re_viewer.js"', b'src="re_viewer.js?v=VERSION"'),
)
"""Old and new. rerun's page must also work as a file, and counts the program's bytes: so it compiles them once all are
there, at every start. What the server answered is compiled while it comes, and kept compiled by browsers that can."""

OUTSIDE = re.compile(rb"<link\b[^>]*https://[^>]*>")
"""Fonts of others for the words before the viewer is there; it brings its own."""


def rerun_page(shipped: bytes) -> bytes:
    """What we serve for `shipped`, the page in rerun's wheel; where it has nothing of CHANGES, it works as shipped."""
    for old, new in CHANGES:
        shipped = shipped.replace(old, new.replace(b"VERSION", VERSION.encode()), 1)
    shipped = OUTSIDE.sub(b"", shipped)
    ours = SEND_COOKIE + STAY_HERE + TELL_ESCAPE + TELL_TOUCHED + QUIET + OPEN_WHEN_TOLD
    return shipped.replace(b"</head>", ours + b"</head>", 1)


@router.get("/rerun/")
@router.get("/rerun/{name}")
async def file(request: Request, review: GivenReview, name: str = "index.html") -> Response:
    """One file of the viewer, compressed where it was compressed before; 503 while it is being extracted.

    Browsers keep a file that was asked for with its version, `?v=`, for good: so they can keep it compiled, too.
    """
    folder = review.viewer
    if name not in FILES:
        return Response(status_code=404)
    if folder is None:
        text = review.problem or "The viewer is being unpacked (once per version). This takes a few seconds."
        return PlainTextResponse(text, 503, {"retry-after": "3", "refresh": "3"})
    if not is_regular(folder / name):
        return PlainTextResponse(f"{folder / name} is gone: the next start unpacks it again.", 503)
    if name == "index.html":
        return Response(rerun_page((folder / name).read_bytes()), media_type=TYPES[".html"])
    tag = f'"{VERSION}"'
    kept = FOR_GOOD if request.query_params.get("v") == VERSION else "no-cache"
    headers = {"etag": tag, "cache-control": kept, "vary": "accept-encoding"}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return _file(folder / name, headers, "gzip" in request.headers.get("accept-encoding", ""))


def _file(path: Path, headers: dict[str, str], gzip: bool) -> Response:
    packed = path.with_name(f"{path.name}.gz")
    if gzip and is_regular(packed):
        # The viewer's progress bar needs the length after decompression.
        headers |= {"content-encoding": "gzip", "rerun-final-length": str(path.stat().st_size)}
        return FileResponse(packed, headers=headers, media_type=TYPES[path.suffix])
    return FileResponse(path, headers=headers, media_type=TYPES[path.suffix])
