"""Rerun's own web viewer, from our origin."""

from pathlib import Path

from fastapi import APIRouter, Request, Response
from starlette.responses import FileResponse, PlainTextResponse

from controller.system.whole_file import is_regular
from recordings.read.viewer import FILES
from server.recorder.rerun_page import VERSION, rerun_page
from server.recorder.review import GivenReview

router = APIRouter(include_in_schema=False)

TYPES = {".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm", ".ico": "image/x-icon"}
FOR_GOOD = "private, max-age=31536000, immutable"


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
