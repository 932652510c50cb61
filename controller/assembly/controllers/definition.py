"""What a controller is made of. A package of its own offers one by the entry point group `tendril.controllers`."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from annotated_types import Ge, Le
from pydantic import BaseModel

from controller.arrays import Array
from controller.errors import ParameterError
from controller.schema.layout import Model, quantity
from controller.schema.messages import ControllerInfo, ControllerNumber, ControllerSignal
from controller.schema.slot import SIGNALS, TUNING


class NoTuning(Model):
    """A controller that has no numbers of its own: its gains are those of the settings."""


@dataclass(frozen=True)
class Signal:
    """A number that a controller shows in every tick."""

    name: str
    unit: str


@dataclass(frozen=True)
class Controller:
    """A controller as the slot takes it."""

    name: str
    """By which it is chosen."""
    title: str
    """In a line, for the page."""
    law: Callable[..., None]
    """Kernel `law(now, reference, tuning, memory, out_wanted)`: see `controller.kernels.slot`."""
    citation: str
    """Where it is from."""
    tuning: type[BaseModel] = NoTuning
    """Its numbers, in order, each with unit and bounds."""
    signals: tuple[Signal, ...] = ()
    plans: bool = False
    """Whether it follows torques that were planned along the reference."""
    own_gains: bool = False
    """Whether it has gains of its own, and takes no heed of the settings' K_P, K_I and K_FF."""

    def __post_init__(self) -> None:
        for name, field in self.tuning.model_fields.items():
            if not {Ge, Le} <= {type(one) for one in field.metadata}:
                raise ParameterError(f"controller {self.name}: {name} needs bounds, ge and le")
        if len(names := list(self.tuning.model_fields)) > TUNING:
            raise ParameterError(f"controller {self.name}: {len(names)} numbers to be tuned by, more than {TUNING}")
        if len(self.signals) > SIGNALS:
            raise ParameterError(f"controller {self.name}: {len(self.signals)} signals, more than {SIGNALS}")

    @property
    def usual(self) -> Array:
        """(TUNING,) what it is tuned to where no other value is given; 0 beyond its own numbers."""
        return self.tuned(self.tuning())

    def tuned(self, values: BaseModel) -> Array:
        """(TUNING,) `values` of its tuning, in its order."""
        found = np.zeros(TUNING)
        found[: len(type(values).model_fields)] = [getattr(values, name) for name in type(values).model_fields]
        return found

    def info(self, refused: str = "") -> ControllerInfo:
        """As others are told of it, and why a rig has `refused` it."""
        return ControllerInfo(
            name=self.name,
            title=self.title,
            citation=self.citation,
            plans=self.plans,
            own_gains=self.own_gains,
            tuning=[self._number(name) for name in self.tuning.model_fields],
            signals=[ControllerSignal(name=one.name, unit=one.unit) for one in self.signals],
            refused=refused,
        )

    def _number(self, name: str) -> ControllerNumber:
        about, kind = self.tuning.model_fields[name], quantity(self.tuning, name)
        bounds = {type(one): one for one in about.metadata}
        return ControllerNumber(
            name=name,
            symbol=kind.symbol or name,
            unit=kind.unit,
            usual=float(about.get_default(call_default_factory=True)),
            low=bounds[Ge].ge,
            high=bounds[Le].le,
            about=about.description or "",
        )
