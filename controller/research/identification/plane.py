"""A decay in space as a motion in its main plane: x along the hanging body, y across."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.motion.decays import Decay

REST_SAMPLES = 20
"""The rest pose of a decay is the mean of its last samples, as many as this."""

FARTHEST = 2.0
"""From the clamp to a body, as in an actuator file [m]."""


@dataclass(frozen=True)
class PlaneMotion:
    """Displacements from rest in the main plane."""

    id: int
    t: Array
    """(n,) [s]."""
    moved: Array
    """(n,bodies,2) along x (down the hanging body) and y (lateral) [m]."""
    outside: float
    """Share of the leading body's lateral motion that lies outside the plane, rms over rms [1]."""
    direction: Array
    """Unit vector (dims,) of y in the file's coordinates."""

    @property
    def lateral(self) -> Array:
        """(n,bodies) [m]."""
        return np.asarray(self.moved[:, :, 1])


def rest_of(decay: Decay) -> Array:
    """Rest pose (bodies,dims) [m]."""
    return np.asarray(decay.points[-REST_SAMPLES:].mean(axis=0))


def hanging_axis(decays: Sequence[Decay]) -> Array:
    """Unit vector (dims,) from the clamp to the tip: the file's coordinate that the bodies at rest follow most.

    Bodies at rest stand a little crooked, but the axes of a tracking system are levelled. One body alone says
    nothing; then it is the coordinate in which it moves least, towards where it hangs.
    """
    rests = np.mean([rest_of(one) for one in decays], axis=0)
    if len(rests) > 1:
        along = rests[-1] - rests[0]
    else:
        spread = np.sum([np.square(one.points[:, 0] - rest_of(one)[0]).mean(axis=0) for one in decays], axis=0)
        along = np.where(np.arange(spread.size) == np.argmin(spread), rests[0], 0.0)
    nearest = int(np.argmax(np.abs(along)))
    return np.asarray(np.sign(along[nearest]) * np.eye(along.size)[nearest])


def body_arcs(decays: Sequence[Decay], axis: Array) -> Array:
    """Arc length of each body (bodies,) [m]: its distance at rest along the axis from the file's origin, the clamp."""
    arcs = np.mean([rest_of(one) @ axis for one in decays], axis=0)
    wrong = np.flatnonzero(np.diff(arcs, prepend=0.0) <= 0.0)
    if wrong.size:
        raise DataError(
            f"body {wrong[0] + 1} rests {1e3 * arcs[wrong[0]]:.1f} mm from the clamp, the one before it farther out: "
            "bodies must be numbered from the clamp, and the clamp at 0 of the coordinate that they hang along"
        )
    if arcs[-1] > FARTHEST:
        raise DataError(
            f"body {arcs.size} rests {arcs[-1]:.4g} m from the clamp, at most {FARTHEST} m are allowed: coordinates "
            "are in m, or in mm where the name of a column ends in _mm"
        )
    return np.asarray(arcs)


def project(decay: Decay, axis: Array, body: int) -> PlaneMotion:
    """`decay` in the plane through the axis in which its body number `body` (from 0) moves most."""
    moved = decay.points - rest_of(decay)
    along = moved @ axis
    across = moved - along[..., None] * axis
    _, size, directions = np.linalg.svd(across[:, body], full_matrices=False)
    lateral, direction = across @ directions[0], directions[0]
    if lateral[np.argmax(np.abs(lateral[:, body])), body] < 0.0:
        lateral, direction = -lateral, -direction
    outside = float(size[1] / size[0]) if size[0] > 0.0 else 0.0
    return PlaneMotion(decay.id, decay.t, np.stack([along, lateral], axis=-1), outside, direction)
