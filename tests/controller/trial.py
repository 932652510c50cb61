"""A rig on its twin without a clock, operated as an operator would: arm, drag, switch, wait."""

from typing import Any

import numpy as np

from controller.arrays import Rows
from controller.assembly.plant import build_plant
from controller.assembly.rig import build_rig
from controller.schema.actuator import PRESETS
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, Telemetry
from controller.schema.modes import Request
from controller.schema.parameters import ControllerParameters, RigParameters, Settings, TwinParameters
from controller.simulation.simulate import Simulation

BOOT = 7


class Trial(Simulation):
    """A simulation with requests as one-liners; every one returns the telemetry of the time that it takes."""

    def __init__(self, name: str = "P1", parameters: RigParameters | None = None, **settings: Any) -> None:
        parameters = parameters or RigParameters(actuator=PRESETS[name])
        self.settings = Settings(**settings)
        super().__init__(
            build_rig(parameters, BOOT), build_plant(parameters), Command(boot=BOOT, settings=self.settings)
        )

    def ask(self, request: Request, target: tuple[float, float] | None = None, ticks: int = 1) -> Rows:
        self.command["request_n"] += 1
        self.command["request"] = request
        if target is not None:
            self.command["target"] = target
        return self.run(ticks)

    def arm(self) -> Rows:
        """Let the markers come in, then arm."""
        self.run(50)
        return self.ask(Request.ARM, ticks=50)

    def follow(self, x: float, y: float, seconds: float) -> Rows:
        return self.ask(Request.FOLLOW, (x, y), round(1000 * seconds))

    def drag(self, path: list[tuple[float, float]], seconds: float) -> Rows:
        """Move the target along `path`, evenly."""
        each = round(1000 * seconds / len(path))
        rows = np.zeros(each * len(path), record_dtype(Telemetry))
        for n, point in enumerate(path):
            self.command["target"] = point
            self.fill(rows[n * each : (n + 1) * each])
        return rows

    def switch(self, **settings: Any) -> None:
        """Change settings live."""
        self.settings = Settings(**{**self.settings.model_dump(), **settings})
        self.command["settings"] = to_record(self.settings)


SOFT: dict[str, Any] = {
    "kappa": 17.4,
    "zeta": 0.26,
    "torque_gain": (1.1, 1.1),
    "set_curvature": (0.0, 0.0),
    "creep": (0.05, 0.05),
    "friction": 0.16,
    "hysteresis": 0.1,
    "inflate_time": 0.044,
    "exhaust_time": 0.05,
}
"""A plant that no calibration changes, softer and less damped than the fitted one."""


def twin_with(name: str = "P1", **changes: Any) -> RigParameters:
    return RigParameters(actuator=PRESETS[name], twin=TwinParameters(**changes))


def controller_with(name: str = "P1", **changes: Any) -> RigParameters:
    return RigParameters(actuator=PRESETS[name], controller=ControllerParameters(**changes))


def true_tip(rows: Rows) -> np.ndarray:
    """The twin's true tip (n,2) [m]."""
    return np.asarray(rows["twin_backbone"][:, -1], np.float64)


def distance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(a - b, axis=-1))


def line(start: tuple[float, float], end: tuple[float, float], points: int) -> list[tuple[float, float]]:
    return [tuple(p) for p in np.linspace(start, end, points)]
