"""One step of whichever plant stands in for the hardware: the loop and every simulation are compiled for its type."""

from typing import Any

from numba.extending import overload

from controller.arrays import Record
from controller.kernels.plant.cosserat import Cosserat, cosserat_step
from controller.kernels.plant.twin import Twin, twin_step

Plant = Twin | Cosserat


def plant_step(t_ns: int, plant: Plant, telemetry: Record, out_measurement: Record) -> None:
    """One step of `plant`, as `twin_step`; for compiled callers, which know its type when they are compiled."""
    if isinstance(plant, Cosserat):
        cosserat_step(t_ns, plant, telemetry, out_measurement)
    else:
        twin_step(t_ns, plant, telemetry, out_measurement)


@overload(plant_step, inline="always")
def _chosen(t_ns: Any, plant: Any, telemetry: Any, out_measurement: Any) -> Any:
    step = cosserat_step if plant.instance_class is Cosserat else twin_step

    def call(t_ns: Any, plant: Any, telemetry: Any, out_measurement: Any) -> Any:
        step(t_ns, plant, telemetry, out_measurement)

    return call
