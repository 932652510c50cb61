"""Presets of gains, and the choice of actuator and plant."""

import asyncio
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter

from controller.errors import CommandRefused, RigUnreachable
from controller.schema.actuator import PRESETS
from controller.schema.modes import Mode
from recordings.write.writer import Recorder
from server.access.asking import Holder, Permitted
from server.http.given import GivenSettings, given
from server.log.events import EventLog, GivenEvents
from server.operate.operator import GivenOperator, Operator
from server.operate.settings import GivenKeptSettings
from server.presets import actuator as actuators
from server.presets.actuator import GivenOutcomes, OutcomeWatch
from server.presets.gains import GainPresets
from server.presets.messages import ActuatorBody, ActuatorChoice, GainPreset, PlantBody, PresetName
from server.rig.client import Rig
from server.rig.planner import GivenPlanner
from server.settings import ServerSettings

router = APIRouter(tags=["presets"])


@router.get("/api/gains")
async def read_gains(settings: GivenSettings) -> list[GainPreset]:
    """The saved presets, by name."""
    return _presets(settings).listed()


@router.put("/api/gains/{name}")
async def save_gains(
    name: PresetName,
    kept: GivenKeptSettings,
    settings: GivenSettings,
    operator: GivenOperator,
    who: Holder,
    events: GivenEvents,
) -> list[GainPreset]:
    """Save the settings in force under this name; all presets."""
    async with kept.changing:
        found = await asyncio.to_thread(_presets(settings).save, name, operator.settings)
    events.add(f"{who.name}: gains saved as {name!r}")
    return found


@router.delete("/api/gains/{name}")
async def delete_gains(
    name: PresetName, kept: GivenKeptSettings, settings: GivenSettings, who: Holder
) -> list[GainPreset]:
    """Delete a preset; the ones that are left."""
    async with kept.changing:
        return await asyncio.to_thread(_presets(settings).delete, name)


@router.get("/api/rig/actuator")
async def read_actuators(settings: GivenSettings, outcomes: GivenOutcomes) -> ActuatorChoice:
    """Which actuators may be chosen, and why none can be."""
    reason = "" if settings.orders else actuators.ELSEWHERE
    return ActuatorChoice(names=list(PRESETS), reason=reason, failure=outcomes.failure)


@dataclass(frozen=True)
class Change:
    """What another actuator is ordered through."""

    rig: Rig
    outcomes: OutcomeWatch
    recorder: Recorder
    operator: Operator
    events: EventLog
    settings: ServerSettings

    def require_rest(self) -> None:
        """Raise CommandRefused unless the rig is VENTED, and nothing is recorded."""
        newest = self.rig.newest
        if self.rig.boot() is None or newest is None:
            raise RigUnreachable("the rig does not answer")
        mode = Mode(newest[0]["mode"])
        if mode != Mode.VENTED:
            raise CommandRefused(f"the actuator cannot be changed in {mode.name}: disarm first")
        if self.recorder.state().recording:
            raise CommandRefused("the actuator cannot be changed while a recording runs: stop it first")


GivenChange = Annotated[Change, given(Change)]


@router.put("/api/rig/actuator", status_code=202)
async def change_actuator(body: ActuatorBody, change: GivenChange, planner: GivenPlanner, permit: Permitted) -> None:
    """Start the rig again with another actuator; 409 unless it is VENTED, ours, and nothing is recorded.

    422 unless the actuator can be built, stands and moves in a simulation. A rig that does not tick with it all the
    same goes back to the actuator before, and the log says why.
    """
    info, in_force = change.rig.require_info(), change.operator.settings
    actuator = await planner.do(actuators.accepted_actuator, body, info.parameters, in_force)
    change.require_rest()
    actuators.order(change.settings.orders, actuator, body, permit)
    change.outcomes.wait_for(actuator.name, change.rig.boot())
    change.events.add(f"{permit.name}: the rig starts again with actuator {actuator.name}", "warning")


@router.put("/api/rig/plant", status_code=202)
async def change_plant(body: PlantBody, change: GivenChange, planner: GivenPlanner, permit: Permitted) -> None:
    """Start the rig again on another simulated plant; refused as another actuator is, and on hardware (409)."""
    info, in_force = change.rig.require_info(), change.operator.settings
    if not info.twin:
        raise CommandRefused("only a twin has a plant to choose, and this rig is hardware")
    name = await planner.do(actuators.accepted_plant, body.plant, info.parameters, in_force)
    change.require_rest()
    actuators.order_plant(change.settings.orders, body.plant, permit)
    change.outcomes.wait_for(name, change.rig.boot())
    change.events.add(f"{permit.name}: the rig starts again with {name}", "warning")


def _presets(settings: ServerSettings) -> GainPresets:
    return GainPresets(settings.state / "gains.json")
