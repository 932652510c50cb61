"""Presets of gains, and the choice of actuator and plant."""

import asyncio

from fastapi import APIRouter

from controller.errors import CommandRefused
from controller.schema.actuator import PRESETS
from server.access.asking import Holder, Permitted
from server.http.given import GivenSettings
from server.log.events import GivenEvents
from server.operate.operator import GivenOperator
from server.operate.settings import GivenKeptSettings
from server.presets import order_files
from server.presets.actuator import accepted_actuator, accepted_observer_kappa, accepted_plant, described
from server.presets.change import GivenChange
from server.presets.gains import GainPresets
from server.presets.messages import (
    ActuatorBody,
    ActuatorChoice,
    GainPreset,
    ObserverKappaBody,
    PlantBody,
    PresetName,
)
from server.presets.outcomes import GivenOutcomes
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
    reason = order_files.why_none(settings.orders)
    return ActuatorChoice(names=list(PRESETS), reason=reason, failure=outcomes.failure)


@router.put("/api/rig/actuator", status_code=202)
async def change_actuator(body: ActuatorBody, change: GivenChange, planner: GivenPlanner, permit: Permitted) -> None:
    """Start the rig again with another actuator; 409 unless it is VENTED, ours, and nothing is recorded.

    422 unless the actuator can be built, stands and moves in a simulation. A rig that does not tick with it all the
    same goes back to the actuator before, and the log says why.
    """
    info, in_force = change.rig.require_info(), change.operator.settings
    actuator = await planner.do(accepted_actuator, body, info.parameters, in_force)
    change.require_rest()
    order_files.order(change.settings.orders, actuator, body, permit)
    change.ordered(actuator.name, f"actuator {actuator.name}", permit)


@router.put("/api/rig/plant", status_code=202)
async def change_plant(body: PlantBody, change: GivenChange, planner: GivenPlanner, permit: Permitted) -> None:
    """Start the rig again on another simulated plant; refused as another actuator is, and on hardware (409)."""
    info, in_force = change.rig.require_info(), change.operator.settings
    if not info.twin:
        raise CommandRefused("only a twin has a plant to choose, and this rig is hardware")
    name = await planner.do(accepted_plant, body.plant, info.parameters, in_force)
    change.require_rest()
    order_files.order_plant(change.settings.orders, body.plant, permit)
    change.ordered(name, name, permit)


@router.put("/api/rig/observer-kappa", status_code=202)
async def change_observer_kappa(
    body: ObserverKappaBody, change: GivenChange, planner: GivenPlanner, permit: Permitted
) -> None:
    """Start the rig again with another inertia in its observer; refused as another actuator is.

    409 beside a rig file, too, which has it as `controller.observer_kappa`.
    """
    info, in_force, file = change.rig.require_info(), change.operator.settings, change.settings.rig_file
    if file is not None:
        raise CommandRefused(f"{file.name} says what the observer's inertia is: change controller.observer_kappa there")
    wanted = await planner.do(accepted_observer_kappa, body.kappa, info.parameters, in_force)
    change.require_rest()
    order_files.order_rig(change.settings.orders, wanted, permit, "--observer-kappa")
    change.ordered(described(wanted), f"kappa = {body.kappa:g} in its observer", permit)


def _presets(settings: ServerSettings) -> GainPresets:
    return GainPresets(settings.state / "gains.json")
