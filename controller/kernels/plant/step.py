"""One step of the hardware, or of whichever plant stands in for it: loop and simulations are compiled for its type."""

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from controller.arrays import Record
from controller.kernels.plant.cosserat import Cosserat, cosserat_step
from controller.kernels.plant.hardware import Hardware, hardware_step
from controller.kernels.plant.twin import Twin, twin_step

Simulated = Twin | Cosserat
Plant = Simulated | Hardware
STEPS: dict[type, Callable[[int, Any, Record, Record], None]] = {
    Twin: twin_step,
    Cosserat: cosserat_step,
    Hardware: hardware_step,
}


def plant_step(t_ns: int, plant: Plant, telemetry: Record, out_measurement: Record) -> None:
    """One step of `plant`, as `twin_step`; for compiled callers, which know its type when they are compiled."""
    STEPS[type(plant)](t_ns, plant, telemetry, out_measurement)


@overload(plant_step, inline="always")
def _chosen(t_ns: Any, plant: Any, telemetry: Any, out_measurement: Any) -> Any:
    step = STEPS[plant.instance_class]

    def call(t_ns: Any, plant: Any, telemetry: Any, out_measurement: Any) -> Any:
        step(t_ns, plant, telemetry, out_measurement)

    return call
