"""Where in an .rrd file each signal is: its entity, and its place among the numbers of a row there."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from recordings.exporting.signals import Signal
from recordings.format.messages import Profile
from recordings.format.profiles import SLOW_FIELDS, TICKS
from recordings.format.signals import BACKBONES, GROUPS
from recordings.read.reader import DENSE, SCALARS, SLOW

CLOCKS = ("tick", "t_ns")
"""Fields that are timelines of every entity."""


@dataclass(frozen=True)
class Place:
    """`column` of `entity`; `sign` -1 where it is written negated, `dense` where it is written at every tick."""

    entity: str
    column: int
    sign: int
    dense: bool


class Layout:
    """Which entities a profile writes, and what is where in them."""

    def __init__(self, profile: Profile) -> None:
        slow, dense = (SLOW_FIELDS, (TICKS,)) if profile == "standard" else (frozenset[str](), GROUPS)
        self.clock = dense[-1].path
        """The entity that is written last at every tick: what has its row there has it everywhere."""
        slower = {path: component for path, (_, component) in SLOW.items()}
        self._components = slower | DENSE | {TICKS.path: SCALARS}
        groups = [(group, True) for group in dense] + [(group, False) for group in GROUPS if slow]
        self._series = {
            (series.field, series.index): Place(group.path, column, 1, is_dense)
            for group, is_dense in groups
            for column, series in enumerate(group.series)
            if is_dense != (series.field in slow)
        }
        self._entities = {field: path for path, (field, _) in SLOW.items()}

    def components_of(self, signals: Iterable[Signal]) -> dict[str, str]:
        """The entities that hold `signals` and the clock, each with the component that has its numbers."""
        return {
            entity: self._components[entity] for entity in {self.clock} | {self.place(one).entity for one in signals}
        }

    def dense(self, signals: Iterable[Signal]) -> set[str]:
        """Those of these entities that are written at every tick."""
        places = [self.place(signal) for signal in signals]
        return {self.clock} | {place.entity for place in places if place.dense}

    def place(self, signal: Signal) -> Place:
        """Where `signal` is."""
        if signal.field in CLOCKS:
            return Place(self.clock, 0, 1, True)
        if signal.field not in self._entities:
            return self._series[signal.field, signal.index[0] if signal.index else None]
        entity = self._entities[signal.field]
        column = int(np.ravel_multi_index(signal.index, record_dtype(Telemetry)[signal.field].shape))
        mirrored = entity in BACKBONES and signal.index[-1] == 1
        return Place(entity, column, -1 if mirrored else 1, False)
