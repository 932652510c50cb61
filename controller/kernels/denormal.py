"""Motion that dies out must not end in denormal numbers: they take the processor a hundred times as long."""

from controller.kernels.compiled import inlined

TINY = 1e-60


@inlined
def flushed(x: float) -> float:
    """x rounded to a multiple of 1e-76; no branch, so a loop over it uses the vector unit. Not in the paper: speed."""
    return (x + TINY) - TINY
