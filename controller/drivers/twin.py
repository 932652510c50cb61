"""The twin as a driver."""

from controller.assembly.plant import Simulated, build_plant
from controller.drivers.driver import Newest, NewestCommand, Post
from controller.kernels.plant.faults import Faults
from controller.schema.hardware import DriverStatus
from controller.schema.messages import TwinFaults
from controller.schema.parameters import RigParameters


class TwinDriver:
    """The simulated plant, of either kind: the loop steps it after every tick and posts what it senses."""

    simulated = True

    def __init__(self, parameters: RigParameters) -> None:
        self.plant: Simulated = build_plant(parameters)

    def start(self, post: Post, newest: Newest, command: NewestCommand) -> None:
        """Nothing to start."""

    def stop(self) -> None:
        """Nothing to stop."""

    def status(self) -> tuple[DriverStatus, ...]:
        """Nothing to say."""
        return ()

    def unready(self) -> str:
        """It always is ready."""
        return ""


def inject(wanted: TwinFaults, faults: Faults) -> None:
    """Put `wanted` in force, one number after the other."""
    faults.values[:] = wanted.noise, wanted.sample_loss, wanted.marker_loss, *wanted.jump
    faults.rods[0], faults.freeze[0] = wanted.rods, wanted.freeze
    faults.pneumatics[:] = wanted.sensors_stuck, wanted.valves_stuck, wanted.supply_lost
