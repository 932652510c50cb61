"""A kernel that is called at its address does what it does when it is called by name, and only with its own types."""

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from numba.core.errors import TypingError

from controller.arrays import Array
from controller.assembly.rig import build_rig
from controller.assembly.stages import stages_of
from controller.assembly.twin import build_twin
from controller.kernels.compiled import kernel
from controller.kernels.control.tick import tick
from controller.kernels.function_pointer import FunctionPointer, call
from controller.kernels.plant.twin import twin_step
from controller.schema.parameters import RigParameters
from controller.simulation import simulate


@kernel
def add(factor: int, x: Array, out_sum: Array) -> None:
    """In place: out_sum."""
    out_sum[0] += factor * x[0]


@kernel
def add_all(adder: Any, count: int, x: Array, out_sum: Array) -> None:
    for i in range(count):
        call(adder, (i, x, out_sum))


@kernel
def add_half(adder: Any, x: Array, out_sum: Array) -> None:
    call(adder, (0.5, x, out_sum))


def test_it_is_called_with_what_it_is_given() -> None:
    x, total = np.array([2.0]), np.zeros(1)
    add_all(FunctionPointer(add, 0, x, total), 5, x, total)
    assert total[0] == 20.0


def test_a_caller_with_other_types_is_not_compiled() -> None:
    x, total = np.array([2.0]), np.zeros(1)
    for adder, given in (
        (FunctionPointer(add, 0, x, total), x),
        (FunctionPointer(add, 0, x, total), x.astype(np.float32)),
    ):
        with pytest.raises(TypingError, match="not the types for which this kernel was compiled"):
            (add_half if given is x else add_all)(*((adder, x, total) if given is x else (adder, 1, given, total)))
    assert total[0] == 0.0


def test_the_code_of_a_simulation_holds_neither_tick_nor_plant() -> None:
    """Else each caller would be compiled with all of it once more."""
    rig, twin = build_rig(RigParameters(), 1), build_twin(RigParameters())
    simulate.simulate(rig, twin, [], 1)
    simulation, whole = code_of(simulate._run), code_of(tick) + code_of(twin_step)
    for kernel_in_it in ("supervise", "step_observer", "advance_pneumatics"):
        assert kernel_in_it in whole and kernel_in_it not in simulation


def code_of(function: Any) -> str:
    (found, *_) = function.overloads.values()
    return str(found.library._get_module_for_linking())


@pytest.mark.process
def test_the_second_process_has_them_from_the_cache() -> None:
    """A rig that had to compile begins again, once: it must be told so of what it calls apart, too."""
    told = """
from controller.assembly.rig import build_rig
from controller.assembly.stages import compiled_here, stages_of
from controller.assembly.twin import build_twin
from controller.schema.parameters import RigParameters
stages_of(build_rig(RigParameters(), 1), build_twin(RigParameters()))
print(compiled_here())
"""
    stages_of(build_rig(RigParameters(), 1), build_twin(RigParameters()))
    assert subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True).stdout == "False\n"
