"""Runs of a reference: start, pause, resume, stop, and what came of the last ones."""

from fastapi import APIRouter

from server.deps import Parts, Permitted
from server.runs.messages import RunBody, RunResult, RunState

router = APIRouter(tags=["runs"])


@router.post("/api/run")
async def start_run(body: RunBody, parts: Parts, permit: Permitted) -> RunState:
    """Follow a reference from where the rig's own is now; 409 when the rig cannot, or another run is under way."""
    parts.operator.present(permit)
    return await parts.runs.start(body, permit)


@router.post("/api/run/pause")
async def pause_run(parts: Parts, permit: Permitted) -> RunState:
    """Hold, and remember where; 409 when no run is in motion."""
    return await parts.runs.pause(permit)


@router.post("/api/run/resume")
async def resume_run(parts: Parts, permit: Permitted) -> RunState:
    """Go on where the run was paused; 409 when none is."""
    parts.operator.present(permit)
    return await parts.runs.resume(permit)


@router.post("/api/run/stop")
async def stop_run(parts: Parts, permit: Permitted) -> RunState:
    """Hold, and end the run; 409 when there is none."""
    return await parts.runs.stop(permit)


@router.get("/api/runs")
async def read_runs(parts: Parts) -> list[RunResult]:
    """What came of the last 100 runs, newest first; kept over a restart of the server."""
    return parts.runs.results()
