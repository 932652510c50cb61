"""Faults injected into the twin's sensing, live."""

import asyncio

from fastapi import APIRouter

from controller.errors import CommandRefused
from controller.messages import TwinFaults
from server.deps import Holder, Parts
from server.services import Services

router = APIRouter(tags=["twin"])


@router.get("/api/twin/faults")
async def read_faults(parts: Parts) -> TwinFaults:
    """What is injected now; 409 on hardware."""
    _require_twin(parts)
    return await asyncio.to_thread(parts.rig.faults)


@router.put("/api/twin/faults")
async def inject_faults(body: TwinFaults, parts: Parts, who: Holder) -> TwinFaults:
    """Inject from the next sample on; 409 on hardware."""
    _require_twin(parts)
    found = await asyncio.to_thread(parts.rig.faults, body)
    parts.events.add(f"{who.name}: {_sentence(found)}", "info" if found == TwinFaults() else "warning")
    return found


def _require_twin(parts: Services) -> None:
    if not parts.require_info().twin:
        raise CommandRefused("faults can be injected into the twin only, and this rig is hardware")


def _sentence(faults: TwinFaults) -> str:
    if faults == TwinFaults():
        return "the twin's markers are as they were"
    noise, samples, markers = faults.noise * 1e3, faults.sample_loss * 100, faults.marker_loss * 100
    return f"injected into the twin's markers: {noise:g} mm noise, {samples:g} % of samples and {markers:g} % lost"
