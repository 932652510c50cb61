"""The slot of a rig: every controller that there is, compiled."""

import logging
from typing import Any

import numpy as np

from controller.assembly.controllers.definition import Controller
from controller.assembly.controllers.registry import OURS, controllers
from controller.kernels.function_pointer import FunctionPointer
from controller.kernels.slot import MEMORY, NOW, WANTED, Slot
from controller.schema.slot import TUNING

log = logging.getLogger(__name__)

_COMPILED: dict[str, FunctionPointer] = {}
"""By the controller's name: machine code stays for as long as this process."""
_BROKEN: set[str] = set()
"""Names of those that could not be compiled."""


def build_slot(rows: int) -> Slot:
    """Nothing chosen but the first, nothing remembered, nothing planned; room for `rows` of a plan."""
    return Slot(
        laws=np.array([address_of(one) for one in controllers()], np.int64),
        now=np.zeros(1, NOW),
        wanted=np.zeros(1, WANTED),
        memory=np.zeros(MEMORY),
        planned=np.zeros((rows, 2)),  # written with every reference: memory that nothing has touched is none
    )


def address_of(controller: Controller) -> int:
    """Of its kernel; of a package's that cannot be compiled that of the first one: no rig lets it be chosen."""
    if controller.name in _BROKEN:
        return compiled(OURS[0]).address
    try:
        return compiled(controller).address
    except Exception as error:  # of numba, or of a package's own
        if controller in OURS:
            raise
        log.warning("controller %s cannot be compiled: %s", controller.name, error)
        _BROKEN.add(controller.name)
        return address_of(controller)


def compiled(controller: Controller) -> FunctionPointer:
    """The kernel of `controller` for what the slot shows it."""
    if controller.name not in _COMPILED:
        _COMPILED[controller.name] = FunctionPointer(controller.law, *shown())
    return _COMPILED[controller.name]


def shown() -> tuple[Any, ...]:
    """What a controller is called with, of the types that the tick gives it."""
    return np.zeros(1, NOW)[0], np.zeros((1, 2)), np.zeros(TUNING), np.zeros(MEMORY), np.zeros(1, WANTED)[0]
