"""What only a twin can do: faults injected live, and time that stands still."""

import asyncio
from collections.abc import Iterator

from fastapi import APIRouter

from controller.errors import CommandRefused
from controller.schema.messages import TwinFaults, TwinTime
from server.access.permit import Permitted
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


@router.get("/api/twin/time")
async def read_time(rig: GivenRig) -> TwinTime:
    """Whether the twin is paused, and how many ticks it still takes; 409 on hardware."""
    _require_twin(rig)
    return await asyncio.to_thread(rig.time)


@router.put("/api/twin/time")
async def set_time(body: TwinTime, rig: GivenRig, permit: Permitted, events: GivenEvents) -> TwinTime:
    """Pause the whole loop between two ticks, let it take `steps` ticks and stand again, or let it go on.

    HOLD, REST and E-STOP end the pause, as does the end of an operator's control. 409 on hardware.
    """
    _require_twin(rig)
    before = rig.paused
    found = await asyncio.to_thread(rig.set_time, body, permit)
    if body.paused != before:
        events.add(f"{permit.name} {'paused the twin' if body.paused else 'let the twin go on'}")
    return found


def _require_twin(rig: Rig) -> None:
    if not rig.require_info().twin:
        raise CommandRefused("only a twin has faults to inject and time to pause, and this rig is hardware")


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
