"""The twin as a driver."""

from controller.build.plant import build_plant
from controller.drivers.driver import Newest, Post
from controller.kernels.plant.step import Plant
from controller.schema.parameters import RigParameters


class TwinDriver:
    """The simulated plant, of either kind: the loop steps it after every tick and posts what it senses."""

    simulated = True

    def __init__(self, parameters: RigParameters) -> None:
        self.twin: Plant = build_plant(parameters)

    def start(self, post: Post, newest: Newest) -> None:
        """Nothing to start."""

    def stop(self) -> None:
        """Nothing to stop."""
