"""The count of lines is of the call alone, wherever in a run of tests it is taken."""

import gc

from tests.controller.drivers.effort import lines_run


class Knot:
    """Garbage that only the collector finds, and whose end costs lines of Python."""

    def __init__(self) -> None:
        self.myself = self

    def __del__(self) -> None:
        for _ in range(50):
            pass


def test_the_end_of_what_earlier_tests_left_is_not_counted():
    lines = lines_run(lambda: [[] for _ in range(100_000)])
    knots = [Knot() for _ in range(20)]
    del knots
    assert lines_run(lambda: [[] for _ in range(100_000)]) == lines
    assert gc.isenabled()
