"""Rerun's own web viewer, from our origin."""

from importlib.metadata import version
from pathlib import Path

from fastapi import APIRouter, Request, Response
from starlette.responses import FileResponse, PlainTextResponse

from recordings.viewer import FILES
from server.deps import Parts
from server.frames import SEND_COOKIE, TELL_ESCAPE

router = APIRouter(include_in_schema=False)

TYPES = {".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm", ".ico": "image/x-icon"}


@router.get("/rerun/")
@router.get("/rerun/{name}")
async def file(request: Request, parts: Parts, name: str = "index.html") -> Response:
    """One file of the viewer, compressed where it was compressed before; 503 while it is being extracted."""
    folder = parts.review.viewer
    if name not in FILES:
        return Response(status_code=404)
    if folder is None:
        text = parts.review.problem or "The viewer is being unpacked (once per version). Reload in a few seconds."
        return PlainTextResponse(text, 503, {"retry-after": "3"})
    if name == "index.html":
        page = (folder / name).read_bytes().replace(b"</head>", SEND_COOKIE + TELL_ESCAPE + b"</head>", 1)
        return Response(page, media_type=TYPES[".html"])
    tag = f'"{version("rerun-sdk")}"'
    headers = {"etag": tag, "cache-control": "no-cache", "vary": "accept-encoding"}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return _file(folder / name, headers, "gzip" in request.headers.get("accept-encoding", ""))


def _file(path: Path, headers: dict[str, str], gzip: bool) -> Response:
    packed = path.with_name(f"{path.name}.gz")
    if gzip and packed.exists():
        # The viewer's progress bar needs the length after decompression.
        headers |= {"content-encoding": "gzip", "rerun-final-length": str(path.stat().st_size)}
        return FileResponse(packed, headers=headers, media_type=TYPES[path.suffix])
    return FileResponse(path, headers=headers, media_type=TYPES[path.suffix])
