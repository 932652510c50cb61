"""Tick and step of the plant, which loop and simulations call in turn: each compiled once, apart from its callers."""

from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from controller.arrays import Record
from controller.assembly.plant import Plant
from controller.kernels.control.tick import Rig, tick
from controller.kernels.function_pointer import FunctionPointer
from controller.kernels.group import GroupType
from controller.kernels.plant.cosserat import Cosserat, cosserat_step
from controller.kernels.plant.hardware import Hardware, hardware_step
from controller.kernels.plant.twin import Twin, twin_step
from controller.schema.layout import record_dtype
from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry

_STEPS: dict[type, Any] = {Twin: twin_step, Cosserat: cosserat_step, Hardware: hardware_step}

# One for each kind of rig and plant that this process has met.
_TICKS: dict[GroupType, FunctionPointer] = {}
_PLANTS: dict[GroupType, FunctionPointer] = {}


class Stages(NamedTuple):
    """For one kind of rig, and one of plant."""

    tick: FunctionPointer
    """`controller.kernels.control.tick.tick`."""
    plant: FunctionPointer
    """The step of whichever plant it is."""


def compiled_here(*callers: Any) -> bool:
    """Whether this process had to compile a stage, or one of `callers`; else all that it has came from the cache."""
    return any(kernel.stats.cache_misses for kernel in (tick, *_STEPS.values(), *callers))


def stages_of(rig: Rig, plant: Plant) -> Stages:
    """Those for `rig` and `plant`, which are looked at only."""
    if rig.kind not in _TICKS:
        command, measurement, status, row = (_record(kind) for kind in (Command, Measurement, LoopStatus, Telemetry))
        _TICKS[rig.kind] = FunctionPointer(tick, 0, command, measurement, status, rig, row)
    return Stages(_TICKS[rig.kind], step_of(plant))


def step_of(plant: Plant) -> FunctionPointer:
    """The step of `plant`, which is looked at only."""
    if plant.kind not in _PLANTS:
        _PLANTS[plant.kind] = FunctionPointer(_STEPS[type(plant)], 0, plant, _record(Telemetry), _record(Measurement))
    return _PLANTS[plant.kind]


def _record(kind: type[BaseModel]) -> Record:
    return np.zeros(1, record_dtype(kind))[0]
