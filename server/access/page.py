"""The page itself, and the address with the token that `tendril up` prints."""

from pathlib import Path

from fastapi import APIRouter, FastAPI, Request, Response
from starlette.responses import FileResponse, PlainTextResponse, RedirectResponse
from starlette.staticfiles import StaticFiles

from server.access.sessions import TooManyAttempts, WrongToken
from server.access.sign_in import GivenSignIn

STATIC = Path(__file__).parents[1] / "static"
"""The built front end."""

router = APIRouter(include_in_schema=False)


@router.get("/")
async def page(request: Request, sign_in: GivenSignIn, token: str | None = None) -> Response:
    """The page. A token in the address becomes a cookie and leaves the address (and so history and Referer)."""
    if token is None:
        return _shell()
    response = RedirectResponse("/", 303)
    try:
        sign_in.open(token, request, response)
    except (WrongToken, TooManyAttempts) as error:
        return _shell(401 if isinstance(error, WrongToken) else 429)
    return response


def mount_assets(app: FastAPI) -> None:
    """Serve the front end's scripts and styles, whose names carry a hash of their content."""
    app.mount("/assets", StaticFiles(directory=STATIC / "assets", check_dir=False), "assets")


def _shell(status: int = 200) -> Response:
    file = STATIC / "index.html"
    if not file.exists():
        return PlainTextResponse("The front end is not built: run `make setup`.", 503)
    return FileResponse(file, status, headers={"cache-control": "no-cache"})
