"""Commissioning: where it stands, its steps begun, ended, accepted and taken back; its report."""

import asyncio

from fastapi import APIRouter, Response
from fastapi.responses import HTMLResponse

from server.access.permit import Permitted
from server.hardware.commissioning.commissioning import GivenCommissioning
from server.hardware.commissioning.messages import (
    CaptureBody,
    CommissioningState,
    ConfirmBody,
    JogBody,
    StartBody,
    StepName,
)
from server.http.answers import body as sends
from server.operate.operator import GivenOperator

router = APIRouter(tags=["commissioning"])


@router.get("/api/commissioning")
async def read_commissioning(commissioning: GivenCommissioning) -> CommissioningState:
    """Where it stands: each step with its result and what it needs to begin, and what the rig still lacks."""
    return await commissioning.state()


@router.post("/api/commissioning/{step}/start", status_code=202)
async def start_commissioning_step(
    step: StepName, body: StartBody, commissioning: GivenCommissioning, operator: GivenOperator, permit: Permitted
) -> CommissioningState:
    """Begin a step; what moves begins and ends with the rig VENTED. 409 says what is missing, 422 the bound."""
    operator.present(permit)
    await commissioning.start(step, body, permit)
    return await commissioning.state()


@router.post("/api/commissioning/{step}/stop")
async def stop_commissioning_step(
    step: StepName, commissioning: GivenCommissioning, permit: Permitted
) -> CommissioningState:
    """End a step: the rig comes to rest and vents, settings are put back; 409 when that step is not under way."""
    commissioning.stop(step, permit)
    return await commissioning.state()


@router.post("/api/commissioning/{step}/accept")
async def accept_commissioning_step(
    step: StepName, commissioning: GivenCommissioning, permit: Permitted
) -> CommissioningState:
    """Write a step's result into the rig file; the rig starts again where that changes it. 409 unless it is done."""
    await commissioning.accept(step, permit)
    return await commissioning.state()


@router.post("/api/commissioning/{step}/back")
async def take_back_commissioning_step(
    step: StepName, commissioning: GivenCommissioning, permit: Permitted
) -> CommissioningState:
    """Forget a step's result and those that rest on it. Values in the rig file stay until they are measured again."""
    await commissioning.back(step, permit)
    return await commissioning.state()


@router.put("/api/commissioning/jog")
async def jog_chamber(body: JogBody, commissioning: GivenCommissioning, permit: Permitted) -> CommissioningState:
    """Fill a chamber while this is renewed, for 0.4 s each time; null lets go. 409 unless the jog step is under way."""
    commissioning.jog(body.chamber, permit)
    return await commissioning.state()


@router.put("/api/commissioning/jog/confirm")
async def confirm_chamber(
    body: ConfirmBody, commissioning: GivenCommissioning, permit: Permitted
) -> CommissioningState:
    """Say which chamber filled when one was jogged; the fourth of these ends the step. 409 unless it was jogged."""
    commissioning.confirm(body, permit)
    return await commissioning.state()


@router.put("/api/commissioning/frame/capture")
async def capture_point(
    body: CaptureBody, commissioning: GivenCommissioning, operator: GivenOperator, permit: Permitted
) -> CommissioningState:
    """Capture base, tip or bent pose; all three end the frame step. 409 where the point is not seen, or moves."""
    operator.present(permit)
    await commissioning.capture(body, permit)
    return await commissioning.state()


@router.get("/api/commissioning/report", response_class=Response, responses=sends("text/html", "The page"))
async def read_commissioning_report(commissioning: GivenCommissioning) -> HTMLResponse:
    """All results as one HTML page with nothing outside it, fit to print."""
    return HTMLResponse(await asyncio.to_thread(commissioning.report))
