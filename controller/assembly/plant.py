"""Whichever plant the parameters ask for."""

import numpy as np

from controller.assembly.cosserat import build_cosserat
from controller.assembly.twin import build_twin
from controller.kernels.plant.cosserat import Cosserat
from controller.kernels.plant.hardware import Hardware
from controller.kernels.plant.twin import Twin
from controller.kernels.plant.valve import PressureLoop
from controller.schema.hardware import Valves
from controller.schema.layout import to_record
from controller.schema.messages import ValveCommand
from controller.schema.parameters import RigParameters

Simulated = Twin | Cosserat
Plant = Simulated | Hardware


def build_plant(parameters: RigParameters) -> Simulated:
    """The simulated plant that `parameters` name, at rest; raises ParameterError where it cannot be built."""
    true = parameters.model_copy(update={"actuator": parameters.plant_actuator or parameters.actuator})
    return build_cosserat(true) if parameters.twin.plant == "cosserat" else build_twin(true)


def build_hardware(valves: Valves, dt: float) -> Hardware:
    """The last stage before real valves, vented; `dt` is the loop's period [s]."""
    loop = valves.loop
    return Hardware(
        command=to_record(ValveCommand()),
        dt=dt,
        pressure_max=valves.pressure_max,
        slew_max=valves.slew_max,
        raw=valves.command == "opening",
        loop=PressureLoop(loop.inflate_gain, loop.exhaust_gain, loop.integral_time),
        integral=np.zeros(4),
    )
