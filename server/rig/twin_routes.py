"""Faults injected into the twin, live."""

import asyncio
from collections.abc import Iterator

from fastapi import APIRouter

from controller.errors import CommandRefused
from controller.schema.messages import TwinFaults
from server.access.asking import Permitted
from server.log.events import GivenEvents
from server.rig.client import GivenRig, Rig

router = APIRouter(tags=["twin"])


@router.get("/api/twin/faults")
async def read_faults(rig: GivenRig) -> TwinFaults:
    """What is injected now; 409 on hardware."""
    _require_twin(rig)
    return await asyncio.to_thread(rig.faults)


@router.put("/api/twin/faults")
async def inject_faults(body: TwinFaults, rig: GivenRig, permit: Permitted, events: GivenEvents) -> TwinFaults:
    """Inject from the next sample on; 409 on hardware."""
    _require_twin(rig)
    found = await asyncio.to_thread(rig.inject, body, permit)
    events.add(f"{permit.name}: {_sentence(found)}", "info" if found == TwinFaults() else "warning")
    return found


def _require_twin(rig: Rig) -> None:
    if not rig.require_info().twin:
        raise CommandRefused("faults can be injected into the twin only, and this rig is hardware")


def _sentence(faults: TwinFaults) -> str:
    if faults == TwinFaults():
        return "the twin is as it was"
    return f"injected into the twin: {', '.join(_words(faults))}"


def _words(faults: TwinFaults) -> Iterator[str]:
    if faults.noise:
        yield f"{faults.noise * 1e3:g} mm noise"
    if faults.sample_loss:
        yield f"{faults.sample_loss * 100:g} % of samples lost"
    if faults.marker_loss:
        yield f"{faults.marker_loss * 100:g} % of markers lost"
    if any(faults.jump):
        yield f"markers moved by {faults.jump[0] * 1e3:g}, {faults.jump[1] * 1e3:g} mm"
    if faults.freeze:
        yield f"markers frozen ({faults.freeze.name.replace('_', ' ').lower()})"
    if faults.sensors_stuck:
        yield f"pressure sensors {_chambers(faults.sensors_stuck)} stuck"
    if faults.valves_stuck:
        yield f"valves {_chambers(faults.valves_stuck)} stuck"
    if faults.supply_lost:
        yield "supply lost"
    if faults == TwinFaults(rods=faults.rods):
        yield "nothing"


def _chambers(bits: int) -> str:
    return " ".join(str(chamber + 1) for chamber in range(4) if bits >> chamber & 1)
