"""The choice of actuator, plant and observer inertia: each starts the rig again."""

from fastapi import APIRouter

from controller.errors import CommandRefused
from controller.schema.actuator import PRESETS
from server.access.asking import Permitted
from server.hardware import order_files
from server.hardware.actuator import accepted_actuator, accepted_observer_kappa, accepted_plant, described
from server.hardware.change import GivenChange
from server.hardware.messages import (
    ActuatorBody,
    ActuatorChoice,
    ObserverKappaBody,
    PlantBody,
)
from server.hardware.outcomes import GivenOutcomes
from server.http.given import GivenSettings
from server.rig.planner import GivenPlanner

router = APIRouter(tags=["presets"])


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
