"""The twin as a driver."""

from controller.build.twin import build_twin
from controller.drivers.driver import Newest, Post
from controller.kernels.plant.twin import Twin
from controller.schema.parameters import RigParameters


class TwinDriver:
    """The simulated plant: the loop steps `twin` after every tick and posts what it senses, so nothing runs here."""

    simulated = True

    def __init__(self, parameters: RigParameters) -> None:
        self.twin: Twin = build_twin(parameters)

    def start(self, post: Post, newest: Newest) -> None:
        """Nothing to start."""

    def stop(self) -> None:
        """Nothing to stop."""
