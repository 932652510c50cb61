"""The quick look at a recording."""

from typing import Annotated

from fastapi import APIRouter, Query, Response

from recordings.read.quick import POINTS, Quick, quick_look
from server.recorder.folder import GivenFolder

router = APIRouter(tags=["recordings"])

Points = Annotated[int, Query(ge=100, le=20_000)]
Keys = Annotated[list[Annotated[str, Query(max_length=80)]], Query(max_length=64)]


@router.get("/api/recordings/{id}/quick", response_model=Quick)
async def recording_quick(id: str, folder: GivenFolder, points: Points = POINTS, signals: Keys = []) -> Response:  # noqa: B006
    """The main signals as extremes of bins, and the tip's path; of a running recording, up to now. 404 without it."""
    text = await folder.look(quick_look, await folder.look(folder.store.path, id), points, tuple(signals))
    return Response(text, media_type="application/json", headers={"cache-control": "no-store"})
