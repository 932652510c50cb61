"""`tendril compile` leaves rig and server nothing to compile, and compiles nothing that they do not call."""

import time
from io import StringIO
from pathlib import Path

import pytest
from numba.core.registry import CPUDispatcher
from rich.console import Console

from controller.errors import ParameterError
from controller.kernels.control.tick import tick
from server.cli import kernels
from server.cli.kernels import compile_kernels, declared, kept


@pytest.mark.process
def test_afterwards_every_kernel_is_in_the_cache_and_the_bar_is_full() -> None:
    shown = StringIO()
    compile_kernels(Console(file=shown))
    assert kept() == declared()
    assert f"{declared()}/{declared()}" in shown.getvalue()


def test_what_another_clone_of_the_same_sources_has_compiled_does_not_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    theirs = tmp_path / "sources" / "kernels_of_another_path"
    theirs.mkdir(parents=True)
    (theirs / "any.nbi").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert kept() == 0


def test_the_stages_of_the_tick_are_compiled_for_its_types_only() -> None:
    """Else those that the parts gave them were compiled for nothing, and the tick's by one process after all."""
    called = [tick.py_func.__globals__.get(name) for name in tick.py_func.__code__.co_names]
    stages = [one for one in called if isinstance(one, CPUDispatcher)]
    compiled = {stage.__name__: len(stage._cache._cache_file._load_index()) for stage in stages}
    assert len(compiled) > 10 and compiled == dict.fromkeys(compiled, 1)


def refuse() -> None:
    raise ParameterError("it cannot be built")


def wait_for_ever() -> None:
    time.sleep(3600.0)


@pytest.mark.process
def test_what_one_part_cannot_do_ends_the_other_and_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "ROUNDS", ((refuse, wait_for_ever),))
    with pytest.raises(ParameterError, match="it cannot be built"):
        compile_kernels(Console(file=StringIO()))
