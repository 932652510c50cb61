"""Which driver a rig has: the twin, or its real devices."""

from controller.drivers.driver import Driver
from controller.drivers.hardware import HardwareDriver
from controller.drivers.twin import TwinDriver
from controller.schema.parameters import RigParameters


def rig_driver(parameters: RigParameters) -> Driver:
    """The driver that `parameters` ask for; raises ParameterError where it cannot be built."""
    if parameters.hardware is None:
        return TwinDriver(parameters)
    return HardwareDriver(parameters, parameters.hardware)
