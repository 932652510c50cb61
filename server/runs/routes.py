"""Runs of a reference: foreseen, started, paused, resumed, stopped, and what came of the last ones."""

from fastapi import APIRouter

from server.access.asking import Permitted
from server.operate.operator import GivenOperator
from server.rig.client import GivenRig
from server.runs.messages import Preview, PreviewBody, RunBody, RunResult, RunState
from server.runs.previews import GivenPreviews
from server.runs.runs import GivenRuns
from server.runs.tracker import standing

router = APIRouter()


@router.post("/api/preview", tags=["drawings"])
async def preview(body: PreviewBody, rig: GivenRig, operator: GivenOperator, previews: GivenPreviews) -> Preview:
    """The run that would follow now, on the twin of the connected rig, far faster than real time."""
    parameters, settings = rig.require_info().parameters, operator.settings
    return await previews.of(body, parameters, settings, standing(rig.newest))


@router.post("/api/run", tags=["runs"])
async def start_run(body: RunBody, runs: GivenRuns, operator: GivenOperator, permit: Permitted) -> RunState:
    """Follow a reference from where the rig's own is now; 409 when the rig cannot, or another run is under way."""
    operator.present(permit)
    return await runs.start(body, permit)


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
