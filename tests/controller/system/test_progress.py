"""What takes long says how much of it is done."""

import io

import numpy as np
from rich.console import Console

from controller.reference.library import reference
from controller.schema.actuator import PRESETS
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.run import PIECE, run
from controller.system.progress import progress


def shown(terminal: bool) -> str:
    text = io.StringIO()
    console = Console(file=text, force_terminal=terminal, width=100, color_system=None)
    with progress(console, "Reading [s]") as told:
        told(0.25)
        told.name("Writing [s]")
        told(1.0)
    return text.getvalue()


def test_a_bar_says_what_is_done_and_how_much_at_a_terminal_only() -> None:
    assert "Writing [s]" in shown(True) and "100%" in shown(True) and ":" in shown(True)
    assert shown(False) == ""


def test_a_run_tells_how_much_is_done_and_has_the_same_bits_as_one_that_does_not() -> None:
    path = reference("circle_1hz", PRESETS["P1"])
    told: list[float] = []
    watched = run(RigParameters(), path, Settings(), 3, told.append)
    assert len(told) == -(-len(path.p) // PIECE) and told == sorted(told) and told[-1] == 1.0
    whole = run(RigParameters(), path, Settings(), 3)
    assert all(
        np.array_equal(watched[name], whole[name], equal_nan=True)
        for name in watched.dtype.names or ()
        if name != "step_ns"
    )
