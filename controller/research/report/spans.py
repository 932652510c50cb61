"""Which rows of a run's trace are drawn, as masks (n,)."""

from controller.arrays import Mask
from controller.research.experiments.results import Finished
from controller.schema.parameters import DT

THERE_AND_BACK = ("vertical", "horizontal", "sweep")
"""Shapes that come back on their own path: half a cycle shows all of it, and its dashes stay dashes."""
HAIR = 1e-9
"""Times are sums of periods [s]."""


def after_approach(run: Finished) -> Mask:
    """From the first point of the shape."""
    shown: Mask = run.trace.t >= run.reference.start * DT - HAIR
    return shown


def last_cycles(run: Finished, cycles: float) -> Mask:
    """The last `cycles` of a periodic reference; all of another."""
    if run.reference.frequency is None:
        return after_approach(run)
    shown: Mask = run.trace.t >= run.trace.t[-1] - cycles / run.reference.frequency - HAIR
    return shown


def once(run: Finished) -> Mask:
    """The reference's shape drawn once: not over and over, and not there and back."""
    if run.reference.frequency is None:
        return after_approach(run)
    begin, period = run.reference.start * DT, 1.0 / run.reference.frequency
    low, high = (0.25, 0.75) if any(shape in run.reference.name for shape in THERE_AND_BACK) else (0.0, 1.0)
    t = run.trace.t - begin
    shown: Mask = (t >= low * period - HAIR) & (t <= high * period + HAIR)
    return shown
