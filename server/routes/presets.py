"""Presets of gains, and the choice of the actuator."""

import asyncio

from fastapi import APIRouter

from controller.errors import CommandRefused, RigUnreachable
from controller.schema.actuator import PRESETS
from controller.schema.modes import Mode
from server.deps import Holder, Parts, Permitted
from server.presets import actuator as actuators
from server.presets.gains import GainPresets
from server.presets.messages import ActuatorBody, ActuatorChoice, GainPreset, PresetName
from server.services import Services

router = APIRouter(tags=["presets"])


@router.get("/api/gains")
async def read_gains(parts: Parts) -> list[GainPreset]:
    """The saved presets, by name."""
    return _presets(parts).listed()


@router.put("/api/gains/{name}")
async def save_gains(name: PresetName, parts: Parts, who: Holder) -> list[GainPreset]:
    """Save the settings in force under this name; all presets."""
    async with parts.settings_lock:
        found = await asyncio.to_thread(_presets(parts).save, name, parts.operator.settings)
    parts.events.add(f"{who.name}: gains saved as {name!r}")
    return found


@router.delete("/api/gains/{name}")
async def delete_gains(name: PresetName, parts: Parts, who: Holder) -> list[GainPreset]:
    """Delete a preset; the ones that are left."""
    async with parts.settings_lock:
        return await asyncio.to_thread(_presets(parts).delete, name)


@router.get("/api/rig/actuator")
async def read_actuators(parts: Parts) -> ActuatorChoice:
    """Which actuators may be chosen, and why none can be."""
    reason = "" if parts.settings.orders else actuators.ELSEWHERE
    return ActuatorChoice(names=list(PRESETS), reason=reason, failure=parts.outcomes.failure)


@router.put("/api/rig/actuator", status_code=202)
async def change_actuator(body: ActuatorBody, parts: Parts, permit: Permitted) -> None:
    """Start the rig again with another actuator; 409 unless it is VENTED, ours, and nothing is recorded.

    422 unless the actuator can be built, stands and moves in a simulation. A rig that does not tick with it all the
    same goes back to the actuator before, and the log says why.
    """
    info, in_force = parts.require_info(), parts.operator.settings
    actuator = await asyncio.to_thread(actuators.accepted_actuator, body, info.parameters, in_force)
    _require_rest(parts)
    actuators.order(parts.settings.orders, actuator, body, permit)
    parts.events.add(f"{permit.name}: the rig starts again with actuator {actuator.name}", "warning")


def _require_rest(parts: Services) -> None:
    newest = parts.history.newest
    if parts.rig.boot() is None or newest is None:
        raise RigUnreachable("the rig does not answer")
    mode = Mode(newest[0]["mode"])
    if mode != Mode.VENTED:
        raise CommandRefused(f"the actuator cannot be changed in {mode.name}: disarm first")
    if parts.recorder.state().recording:
        raise CommandRefused("the actuator cannot be changed while a recording runs: stop it first")


def _presets(parts: Services) -> GainPresets:
    return GainPresets(parts.settings.state / "gains.json")
