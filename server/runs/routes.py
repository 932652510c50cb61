"""Runs of a reference: foreseen, started, paused, resumed, stopped, and what came of the last ones."""

from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing

from fastapi import APIRouter
from starlette.responses import StreamingResponse

from controller.errors import TendrilError
from server.access.permit import Permitted
from server.http import answers
from server.http.answers import JSON_LINES, json_line
from server.http.errors import NotFound
from server.operate.operator import GivenOperator
from server.rig.client import GivenRig
from server.runs.learning.plans import GivenPlans
from server.runs.messages import LessonKey, Preview, PreviewBody, PreviewPart, RunBody, RunResult, RunState
from server.runs.previews import GivenPreviews
from server.runs.runs import GivenRuns
from server.runs.tracker import standing

router = APIRouter()


@router.post("/api/preview", tags=["drawings"])
async def preview(body: PreviewBody, rig: GivenRig, operator: GivenOperator, previews: GivenPreviews) -> Preview:
    """The run that would follow now, on the twin of the connected rig, far faster than real time."""
    return await previews.of(body, rig.require_info(), operator.settings, standing(rig.newest))


@router.post(
    "/api/preview/parts",
    tags=["drawings"],
    response_class=StreamingResponse,
    response_model=PreviewPart,
    responses=answers.body(JSON_LINES, "A `PreviewPart` in each line"),
)
async def preview_parts(
    body: PreviewBody, rig: GivenRig, operator: GivenOperator, previews: GivenPreviews
) -> StreamingResponse:
    """The same as it comes: a line of JSON for each part, the whole in the last one. Who hangs up ends it."""
    parts = previews.parts(body, rig.require_info(), operator.settings, standing(rig.newest))
    first = await anext(parts)  # what cannot be foreseen at all is refused as ever
    return StreamingResponse(_lines(first, parts), media_type=JSON_LINES)


async def _lines(first: PreviewPart, parts: AsyncGenerator[PreviewPart, None]) -> AsyncIterator[str]:
    last = first
    try:
        async with aclosing(parts):
            yield json_line(first)
            async for last in parts:
                yield json_line(last)
    except TendrilError as error:
        rest = {"first": last.first + len(last.t), "t": [], "points": [], "saturated": [], "preview": None}
        yield json_line(last.model_copy(update=rest | {"problem": str(error)}))


@router.post("/api/run", tags=["runs"])
async def start_run(body: RunBody, runs: GivenRuns, operator: GivenOperator, permit: Permitted) -> RunState:
    """Follow a reference from where the rig's own is now; 409 when the rig cannot, or another run is under way."""
    operator.present(permit)
    return await runs.start(body, permit)


@router.post("/api/run/again", tags=["runs"])
async def run_again(runs: GivenRuns, operator: GivenOperator, permit: Permitted) -> RunState:
    """Follow what was followed last, as often; 409 as for `/api/run`, and when nothing was since the server started."""
    operator.present(permit)
    return await runs.again(permit)


@router.delete("/api/learned/{key}", tags=["runs"])
async def forget_path(key: LessonKey, plans: GivenPlans, _: Permitted) -> None:
    """Forget what was learned of a path; the next run of it is as planned. 404 where nothing was."""
    if not await plans.forget(key):
        raise NotFound("nothing is known of this path")


@router.post("/api/run/pause", tags=["runs"])
async def pause_run(runs: GivenRuns, permit: Permitted) -> RunState:
    """Hold, and remember where; 409 when no run is in motion."""
    return await runs.pause(permit)


@router.post("/api/run/resume", tags=["runs"])
async def resume_run(runs: GivenRuns, operator: GivenOperator, permit: Permitted) -> RunState:
    """Go on where the run was paused; 409 when none is."""
    operator.present(permit)
    return await runs.resume(permit)


@router.post("/api/run/stop", tags=["runs"])
async def stop_run(runs: GivenRuns, permit: Permitted) -> RunState:
    """Hold, and end the run; 409 when there is none."""
    return await runs.stop(permit)


@router.get("/api/runs", tags=["runs"])
async def read_runs(runs: GivenRuns) -> list[RunResult]:
    """What came of the last 100 runs, newest first; kept over a restart of the server."""
    return runs.results()
