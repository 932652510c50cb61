"""Where everything is planned and foreseen that needs the kernels: a process of its own."""

from typing import Annotated

from controller.system.work_process import WorkProcess
from server.http.given import given

NAME = "planning"


class Planner(WorkProcess):
    """It knows the actuators that it was asked about last, so the second question is answered at once."""

    def __init__(self) -> None:
        super().__init__(NAME)


GivenPlanner = Annotated[Planner, given(Planner)]
