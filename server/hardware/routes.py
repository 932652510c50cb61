"""The rig's choice of actuator, plant and observer inertia, its first mode, how its devices fare, and its rig file."""

import asyncio

from fastapi import APIRouter

from controller.errors import CommandRefused
from controller.schema.actuator import PRESETS
from controller.schema.hardware import Drivers
from server.access.permit import Permitted
from server.hardware import restart_files
from server.hardware.actuator import accepted_actuator, accepted_observer_kappa, accepted_plant, described
from server.hardware.first_mode.measurement import GivenMeasurement
from server.hardware.first_mode.messages import FirstModeBody, FirstModeInForce, FirstModeState, in_force
from server.hardware.first_mode.store import GivenFirstModes, plant_of
from server.hardware.messages import (
    ActuatorBody,
    ActuatorChoice,
    ObserverKappaBody,
    PlantBody,
    RigFileState,
    RigFileText,
)
from server.hardware.outcomes import GivenChange, GivenOutcomes
from server.hardware.rig_file import GivenRigFile
from server.http.given import GivenSettings
from server.operate.operator import GivenOperator
from server.rig.client import GivenRig
from server.rig.planner import GivenPlanner

router = APIRouter()


@router.get("/api/rig/actuator", tags=["presets"])
async def read_actuators(settings: GivenSettings, outcomes: GivenOutcomes) -> ActuatorChoice:
    """Which actuators may be chosen, and why none can be."""
    reason = restart_files.why_none(settings.restarts)
    return ActuatorChoice(names=list(PRESETS), reason=reason, failure=outcomes.failure)


@router.put("/api/rig/actuator", status_code=202, tags=["presets"])
async def change_actuator(body: ActuatorBody, change: GivenChange, planner: GivenPlanner, permit: Permitted) -> None:
    """Start the rig again with another actuator; 409 unless it is VENTED, ours, and nothing is recorded.

    422 unless the actuator can be built, stands and moves in a simulation. A rig that does not tick with it all the
    same goes back to the actuator before, and the log says why.
    """
    info, in_force = change.rig.require_info(), change.operator.settings
    actuator = await planner.do(accepted_actuator, body, info.parameters, in_force)
    change.require_rest()
    restart_files.request_actuator(change.settings.restarts, actuator, body, permit)
    change.requested(actuator.name, f"actuator {actuator.name}", permit)


@router.put("/api/rig/plant", status_code=202, tags=["presets"])
async def change_plant(body: PlantBody, change: GivenChange, planner: GivenPlanner, permit: Permitted) -> None:
    """Start the rig again on another simulated plant, or with other numbers of the twin.

    Refused as another actuator is, and on hardware (409).
    """
    info, in_force = change.rig.require_info(), change.operator.settings
    if not info.twin:
        raise CommandRefused("only a twin has a plant to choose, and this rig is hardware")
    wanted = await planner.do(accepted_plant, body, info.parameters, in_force)
    change.require_rest()
    restart_files.request_rig(change.settings.restarts, wanted, permit, "--plant")
    with_numbers = f", twin: {body.numbers or 'as usual'}" if body.numbers is not None else ""
    change.requested(described(wanted), f"{described(wanted)}{with_numbers}", permit)


@router.put("/api/rig/observer-kappa", status_code=202, tags=["presets"])
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
    restart_files.request_rig(change.settings.restarts, wanted, permit, "--observer-kappa")
    change.requested(described(wanted), f"kappa = {body.kappa:g} in its observer", permit)


@router.get("/api/first-mode", tags=["presets"])
async def read_first_mode(rig: GivenRig, modes: GivenFirstModes, planner: GivenPlanner) -> FirstModeInForce:
    """Damping ratio and kappa of the rig's actuator: measured, of its file or assumed; 503 before the first contact."""
    info = rig.require_info()
    return await planner.do(in_force, info.parameters, modes.of(info.parameters.actuator, plant_of(info)))


@router.post("/api/first-mode/measure", status_code=202, tags=["presets"])
async def measure_first_mode(
    body: FirstModeBody, measurement: GivenMeasurement, operator: GivenOperator, permit: Permitted
) -> FirstModeState:
    """Measure them by small steps in open loop, some 25 s; 409 unless the rig holds or follows, 422 for too far."""
    operator.present(permit)
    return await measurement.start(body, permit)


@router.post("/api/first-mode/stop", tags=["presets"])
async def stop_first_mode(measurement: GivenMeasurement, permit: Permitted) -> FirstModeState:
    """End the measurement, and hold; 409 when none goes on."""
    return measurement.stop(permit)


@router.get("/api/drivers", tags=["hardware"])
async def read_drivers(rig: GivenRig) -> Drivers:
    """How each of the rig's drivers fares, now, with its newest raw values; none of a twin. 503 without the rig."""
    rig.require_info()
    return await asyncio.to_thread(rig.drivers)


@router.get("/api/rig-file", tags=["hardware"])
async def read_rig_file(keeper: GivenRigFile) -> RigFileState:
    """The rig file, and whether the rig runs with what it says."""
    return await asyncio.to_thread(keeper.state)


@router.put("/api/rig-file", status_code=202, tags=["hardware"])
async def write_rig_file(body: RigFileText, keeper: GivenRigFile, permit: Permitted) -> None:
    """Check, write and restart the rig; 409 unless it is VENTED, ours, and nothing is recorded.

    422 names field, value and bound. A rig that does not tick with it goes back to what ticked last, and the log says
    why; the file then holds what was written.
    """
    await keeper.write(body.text, permit)
