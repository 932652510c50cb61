"""No kernel allocates: read in the machine code, and counted while it runs."""

import importlib
import pkgutil
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numba import njit, typeof
from numba.core.errors import NumbaError
from numba.core.registry import CPUDispatcher
from numba.core.runtime import _nrt_python, rtsys

import controller.kernels
from controller.assembly.controllers.slot import shown
from controller.assembly.cosserat import build_cosserat
from controller.assembly.plant import build_hardware, build_plant
from controller.assembly.rig import build_rig
from controller.assembly.rod import build_rod
from controller.assembly.twin import build_twin
from controller.kernels.compiled import OPTIONS
from controller.kernels.control.adaptive import adaptive
from controller.kernels.control.along import invert_along, refine_each
from controller.kernels.control.inverse import invert
from controller.kernels.control.retime import fastest_progress
from controller.kernels.control.task_space_pi import letter, paper
from controller.kernels.control.tick import tick
from controller.kernels.model.equilibrium import lead_pose, make_scratch, out_of_balance, settle
from controller.kernels.model.implicit import make_implicit_work, meet_hinges
from controller.kernels.model.rod import make_load
from controller.kernels.model.statics import at_rest, places, tip_angles_of, tips_of
from controller.kernels.observer.foreseen import foresee_tip, move_torques
from controller.kernels.observer.observer import Replay
from controller.kernels.observer.replay import RecordedSamples, replay
from controller.kernels.plant.cosserat import cosserat_step
from controller.kernels.plant.hardware import hardware_step
from controller.kernels.plant.twin import twin_step
from controller.schema.hardware import Valves
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry
from controller.schema.parameters import PlantKind, RigParameters, TwinParameters
from controller.simulation.simulate import Simulation

ALLOCATORS = re.compile(r"NRT_\w*alloc\w*|\b[mc]alloc\b|\brealloc\b|\bposix_memalign\b", re.IGNORECASE)
WITH_RUNTIME: dict[str, Any] = {**OPTIONS, "_nrt": True}


def kernels() -> dict[str, CPUDispatcher]:
    """Every compiled function that a module of controller.kernels defines."""
    found = {}
    for info in pkgutil.walk_packages(controller.kernels.__path__, "controller.kernels."):
        for name, value in vars(importlib.import_module(info.name)).items():
            if isinstance(value, CPUDispatcher) and value.py_func.__module__ == info.name:
                found[name] = value
    return found


def called_by(kernel: CPUDispatcher) -> Iterator[CPUDispatcher]:
    names = kernel.py_func.__globals__
    return (names[name] for name in kernel.py_func.__code__.co_names if isinstance(names.get(name), CPUDispatcher))


def allocators(kernel: CPUDispatcher, arguments: tuple[Any, ...]) -> set[str]:
    """Names of allocators in the code of `kernel`, which holds that of all it calls: in its LLVM, and in what runs.

    Both as they lie in the cache, for which numba has members of its own only; to compile them again takes a minute.
    """
    signature = tuple(typeof(argument) for argument in arguments)
    kernel.compile(signature)
    (_, _, (machine_code, _)), *_ = kernel._cache._cache_file.load(
        kernel._cache._index_key(signature, kernel.targetctx.codegen())
    )
    llvm = str(kernel.overloads[signature].library._get_module_for_linking())
    return set(ALLOCATORS.findall(llvm)) | set(ALLOCATORS.findall(machine_code.decode("latin-1")))


def outermost() -> dict[str, tuple[Any, ...]]:
    """Example arguments of each kernel that no other kernel calls; together they contain all kernels."""
    rig, twin = build_rig(RigParameters(), 1), build_twin(RigParameters())
    command, measurement, status = to_record(Command(boot=1)), to_record(Measurement()), to_record(LoopStatus())
    telemetry = np.zeros(1, record_dtype(Telemetry))
    model = build_rod(RigParameters().actuator, 10)
    state, work, points = at_rest(model), make_implicit_work(10, 1), np.zeros((1, 2))
    at = places(model, np.array([0.1]))
    run = Replay(model, state, make_load(10, 1), work, at, np.zeros(10), np.zeros(2), 1e-3)
    samples = RecordedSamples(points[None], points[None], np.ones(1, np.int64), 0.05)
    smap, scratch = rig.control.smap, make_scratch(10)
    return {
        "tick": (1, command[0], measurement[0], status[0], rig, telemetry[0]),
        "twin_step": (1, twin, telemetry[0], measurement[0]),
        "cosserat_step": (1, build_cosserat(RigParameters()), telemetry[0], measurement[0]),
        "hardware_step": (1, build_hardware(Valves(driver="serial"), 1e-3), telemetry[0], measurement[0]),
        "meet_hinges": (model, state.q, state.v, work),
        "replay": (1, samples, run, points[None]),
        "invert_along": (smap, points, 0, (0.0, 0.0), 1, 1, np.zeros(1), scratch, points.copy()),
        "refine_each": (smap, 1, points.copy(), points.copy(), scratch),
        "fastest_progress": (points, points, np.ones(1), 1.0, np.ones(1)),
        "invert": (smap, (0.0, 0.0), (0.0, 0.0), True, scratch),
        "out_of_balance": (smap.statics.body, 0.0, 0.0, scratch),
        "lead_pose": (smap.statics.body, model.rest, (0.0, 0.0), (0.0, 0.0), scratch),
        "settle": (smap.statics.body, model.rest.copy(), np.zeros(10), np.zeros(10)),
        **{law.__name__: shown() for law in (paper, letter, adaptive)},
        "foresee_tip": (points, rig.observer, points.copy()),
        "move_torques": (points, 0.1, smap, scratch, points.copy()),
        "tips_of": (smap.statics, points, scratch, points.copy()),
        "tip_angles_of": (smap.statics, points, scratch, np.zeros(1)),
    }


def allocating(x: np.ndarray) -> float:
    scratch = np.zeros(x.size)
    scratch[0] = x[0]
    return float(scratch.sum())


hidden = njit(**WITH_RUNTIME)(allocating)


def calls_hidden(x: np.ndarray) -> float:
    return float(hidden(x))


def test_the_examples_reach_every_kernel() -> None:
    found = kernels()
    known = {
        tick,
        twin_step,
        cosserat_step,
        hardware_step,
        meet_hinges,
        replay,
        invert_along,
        refine_each,
        fastest_progress,
        invert,
    }
    known |= {paper, letter, adaptive, foresee_tip, move_torques}
    assert known | {lead_pose, out_of_balance, settle, tips_of, tip_angles_of} == {found[name] for name in outermost()}
    called = {inner for kernel in found.values() for inner in called_by(kernel)}
    assert {name for name, kernel in found.items() if kernel not in called} == outermost().keys()


@pytest.mark.parametrize(
    "name",
    [
        "tick",
        "twin_step",
        "cosserat_step",
        "hardware_step",
        "meet_hinges",
        "replay",
        "invert_along",
        "invert",
        "tip_angles_of",
        "paper",
        "adaptive",
        "foresee_tip",
        "move_torques",
    ],
)
def test_the_machine_code_of_no_kernel_calls_an_allocator(name: str) -> None:
    assert allocators(kernels()[name], outermost()[name]) == set()


@pytest.mark.parametrize("function", [allocating, calls_hidden])
def test_the_same_look_finds_an_array_that_a_kernel_makes(function: Callable[..., Any]) -> None:
    found = allocators(njit(**WITH_RUNTIME)(function), (np.ones(3),))
    assert any(name.startswith("NRT_") for name in found)


def test_a_kernel_that_makes_an_array_does_not_compile() -> None:
    with pytest.raises(NumbaError):
        njit(**OPTIONS | {"cache": False})(allocating)(np.ones(3))  # in the cache lies the one with the runtime


def test_every_kernel_is_compiled_without_the_runtime_that_allocates() -> None:
    assert [name for name, kernel in kernels().items() if kernel.targetoptions.get("_nrt", True)] == []


@pytest.mark.parametrize("plant", ["rod", "cosserat"])
def test_ten_thousand_ticks_take_no_memory(plant: PlantKind) -> None:
    parameters = RigParameters(twin=TwinParameters(plant=plant))
    simulation = Simulation(build_rig(parameters, 1), build_plant(parameters), Command(boot=1))

    def allocated(ticks: int) -> int:
        before = rtsys.get_allocation_stats().alloc
        simulation.run(ticks)
        return int(rtsys.get_allocation_stats().alloc - before)

    _nrt_python.memsys_enable_stats()
    try:
        simulation.run(1)
        assert allocated(10_000) == allocated(1)  # what the caller of the ticks makes once
        before = rtsys.get_allocation_stats().alloc
        hidden(np.ones(3))
        assert rtsys.get_allocation_stats().alloc == before + 2  # its argument's handle, and its array
    finally:
        _nrt_python.memsys_disable_stats()
