"""The first mode: what is known of it, and its measurement."""

from fastapi import APIRouter

from server.access.asking import Permitted
from server.hardware.first_mode.measurement import GivenMeasurement
from server.hardware.first_mode.messages import FirstModeBody, FirstModeInForce, FirstModeState, in_force
from server.hardware.first_mode.store import GivenFirstModes, plant_of
from server.operate.operator import GivenOperator
from server.rig.client import GivenRig

router = APIRouter(tags=["presets"])


@router.get("/api/first-mode")
def read_first_mode(rig: GivenRig, modes: GivenFirstModes) -> FirstModeInForce:
    """Damping ratio and kappa of the rig's actuator, measured or assumed; 503 before the first contact."""
    info = rig.require_info()
    return in_force(info.parameters, modes.of(info.parameters.actuator, plant_of(info)))


@router.post("/api/first-mode/measure", status_code=202)
async def measure_first_mode(
    body: FirstModeBody, measurement: GivenMeasurement, operator: GivenOperator, permit: Permitted
) -> FirstModeState:
    """Measure them by small steps in open loop, some 25 s; 409 unless the rig holds or follows, 422 for too far."""
    operator.present(permit)
    return await measurement.start(body, permit)


@router.post("/api/first-mode/stop")
async def stop_first_mode(measurement: GivenMeasurement, permit: Permitted) -> FirstModeState:
    """End the measurement, and hold; 409 when none goes on."""
    return measurement.stop(permit)
