"""A first-order lag, as a chamber has after its dead time (PHYSICS: "Pneumatics"; paper, "Dynamic observer")."""

from scipy.signal import lfilter

from controller.arrays import Array


def lagged(u: Array, keep: float, start: Array) -> Array:
    """What follows `u` (...,n), in its unit; it was at `start` (...,1) one sample before the first.

    `keep` = exp(-dt / tau) is what it keeps of its distance from one sample to the next.
    """
    found: Array = lfilter([1.0 - keep], [1.0, -keep], u, zi=keep * start)[0]
    return found
