"""The fastest progress along sampled points within bounds (Bobrow, Dubowsky, Gibson 1985), as x = (d index / d t)^2."""

import math

from controller.arrays import Array
from controller.kernels.compiled import kernel


@kernel
def fastest_progress(first: Array, second: Array, most: Array, acceleration: float, out_x: Array) -> None:
    """The largest progress x (n,) [1/s^2] that is 0 at both ends, <= `most` (n,), and slow enough all along.

    With derivatives q' and q'' (n,2) by the index, |q'' x + q' dx/2| <= `acceleration` has to hold; x is linear
    between the indices. One pass each way finds it. Not in the paper: Bobrow, Dubowsky, Gibson 1985.
    """
    n = out_x.shape[0]
    for i in range(n):
        out_x[i] = min(most[i], bend_limit(first, second, i, acceleration))
    out_x[0] = out_x[n - 1] = 0.0
    for i in range(n - 1):
        out_x[i + 1] = min(out_x[i + 1], next_progress(first, second, i, 1.0, acceleration, out_x[i]))
    for i in range(n - 1, 0, -1):
        out_x[i - 1] = min(out_x[i - 1], next_progress(first, second, i, -1.0, acceleration, out_x[i]))


@kernel
def bend_limit(first: Array, second: Array, i: int, acceleration: float) -> float:
    """The largest x at index i that any change of it allows: the part of q'' across q' is all centripetal.

    Not in the paper: Bobrow, Dubowsky, Gibson 1985.
    """
    d, c = math.hypot(first[i, 0], first[i, 1]), math.hypot(second[i, 0], second[i, 1])
    across = abs(first[i, 0] * second[i, 1] - first[i, 1] * second[i, 0])
    if across > 0.0:
        return acceleration * d / across
    return acceleration / c if d == 0.0 and c > 0.0 else math.inf


@kernel
def next_progress(first: Array, second: Array, i: int, way: float, acceleration: float, x: float) -> float:
    """The largest progress one index further (`way` 1) or back (-1) from x at i: largest y, q'' x + way q' y within.

    Not in the paper: Bobrow, Dubowsky, Gibson 1985.
    """
    d2 = first[i, 0] ** 2 + first[i, 1] ** 2
    if d2 == 0.0:
        return math.inf
    b = way * (first[i, 0] * second[i, 0] + first[i, 1] * second[i, 1]) * x
    c = (second[i, 0] ** 2 + second[i, 1] ** 2) * x * x - acceleration * acceleration
    room = b * b - d2 * c
    y = (-b + math.sqrt(max(0.0, room))) / d2
    return max(0.0, x + 2.0 * y)
