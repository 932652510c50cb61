"""Which controllers there are: ours, and those of packages that offer some."""

from collections.abc import Mapping
from functools import cache
from importlib.metadata import entry_points
from typing import Annotated

from pydantic import Field as Bounds
from pydantic import ValidationError

from controller.assembly.controllers.definition import Controller, Signal
from controller.errors import ParameterError, sentence
from controller.kernels.control.adaptive import adaptive
from controller.kernels.control.preview import preview
from controller.kernels.control.task_space_pi import letter, paper
from controller.schema.layout import Model
from controller.schema.layout import Quantity as Q
from controller.schema.parameters import Settings
from controller.schema.slot import PREVIEW_TUNING

GROUP = "tendril.controllers"
"""Entry points of other packages."""


class PreviewTuning(Model):
    """What `preview` is tuned by."""

    K_P: Annotated[float, Bounds(ge=0.0, le=2.0), Q("1", "K_P")] = PREVIEW_TUNING[0]
    K_I: Annotated[float, Bounds(ge=0.0, le=20.0), Q("1/s", "K_I")] = PREVIEW_TUNING[1]
    lag: Annotated[float, Bounds(ge=0.0, le=2.0), Q("s", "tau_P")] = PREVIEW_TUNING[2]
    """Time constant with which P follows the error: it rolls P off below the arm's first mode."""


class AdaptiveTuning(PreviewTuning):
    """What `adaptive` is tuned by."""

    rate: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1/s")] = 0.1
    """How quickly what was learned makes room for what is learned now; 0 freezes it."""
    most: Annotated[float, Bounds(ge=0.0, le=0.5), Q("1")] = 0.3
    """Share of the quasi-static feedforward that it may add or take."""


OURS = (
    Controller("paper", "The paper's PI, its integral kept as a torque", paper, 'paper, "Task-space PI control"'),
    Controller("letter", "The paper's PI to the letter", letter, 'paper, "Task-space PI control"'),
    Controller(
        "preview",
        "Torques planned along the reference, PI on the prediction",
        preview,
        'Smith, "Closer control of loops with dead time", 1957',
        PreviewTuning,
        (Signal("e_x", "m"), Signal("e_y", "m"), Signal("u_int_1", "N m"), Signal("u_int_2", "N m")),
        plans=True,
        own_gains=True,
    ),
    Controller(
        "adaptive",
        "preview, with a feedforward that adapts to the arm",
        adaptive,
        'Ioannou, Sun, "Robust Adaptive Control", 1996, 4.3',
        AdaptiveTuning,
        (
            *(Signal("e_x", "m"), Signal("e_y", "m"), Signal("u_int_1", "N m"), Signal("u_int_2", "N m")),
            *(Signal("sigma_1", "1"), Signal("sigma_2", "1"), Signal("tau_1", "s"), Signal("tau_2", "s")),
        ),
        plans=True,
        own_gains=True,
    ),
)
"""In the order of `Settings.controller`."""


@cache
def controllers() -> tuple[Controller, ...]:
    """All of them, ours first, the others by name. ParameterError where two have one name."""
    found = list(OURS)
    for offered in sorted(entry_points(group=GROUP), key=lambda one: one.name):
        one = offered.load()
        if not isinstance(one, Controller):
            raise ParameterError(f"{GROUP}: {offered.value} is a {type(one).__name__}, no Controller")
        found.append(one)
    names = [one.name for one in found]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ParameterError(f"{GROUP}: more than one controller has the name {', '.join(twice)}")
    return tuple(found)


def with_controller(settings: Settings, name: str, tuning: Mapping[str, float] | None = None) -> Settings:
    """`settings` with the controller of this name, tuned as usual but for the numbers of `tuning`.

    ParameterError with name, value and bound for a controller or a number that there is not, or that is out of bounds.
    """
    number = index_of(name)
    chosen = controllers()[number]
    if unknown := sorted(set(tuning or {}) - set(names := list(chosen.tuning.model_fields))):
        known = f"one of {', '.join(names)}" if names else "tuned by any"
        raise ParameterError(f"{', '.join(unknown)}: controller {name} is not {known}")
    try:
        values = chosen.tuning.model_validate(dict(tuning or {}))
    except ValidationError as error:
        raise ParameterError(f"controller {name}: {sentence(error)}") from error
    return settings.model_copy(update={"controller": number, "tuning": tuple(chosen.tuned(values).tolist())})


def index_of(name: str) -> int:
    """Place of the controller of this name, as in `Settings.controller`. ParameterError for one that there is not."""
    names = [one.name for one in controllers()]
    if name not in names:
        raise ParameterError(f"controller = {name!r} is not one of {', '.join(names)}")
    return names.index(name)
