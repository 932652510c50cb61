"""Times of compiled steps on a machine that other programs use too."""

import time
from collections.abc import Callable


def time_steps(run: Callable[[int], object], count: int) -> float:
    """Time of one of `count` steps that `run(count)` makes [us]; one is made before the clock starts.

    Choose `count` for about 2 ms in all: shorter than another program's turn on the core, so that most rounds are
    undisturbed.
    """
    run(1)
    start = time.perf_counter()
    run(count)
    return (time.perf_counter() - start) / count * 1e6
