"""Whether a body bends alike in every direction, by the shapes of its first mode (docs/identification.md)."""

import numpy as np

from controller.arrays import Array

SURE = 1e-4
"""Standard error of a ratio, at least."""
DECAYS_MIN = 6
"""Decays: three coefficients of the law, and as many to judge it by."""
GAIN = 0.1
"""What directions must take off the squared errors of left-out decays: less is a tie, which the simpler form wins."""
DECISIVE = 0.05
"""A decay whose own ratio decides its prediction by more than all but this share is not predicted by the others."""


def across_body(axis: Array) -> Array:
    """The file's two coordinates across the body (2,dims), which hangs along one of them."""
    return np.delete(np.eye(axis.size), int(np.argmax(np.abs(axis))), axis=0)


def direction_law(directions: Array, axis: Array, *, directional: bool) -> Array:
    """Regressors (d,1) or (d,3) of ratios: 1, and cos 2 phi and sin 2 phi of the directions of bending (d,dims)."""
    one = np.ones((len(directions), 1))
    if not directional:
        return one
    x, y = across_body(axis) @ directions.T
    phi = np.arctan2(y, x)
    return np.column_stack([one, np.cos(2 * phi), np.sin(2 * phi)])


def law_scatter(law: Array, ratios: Array) -> Array:
    """Scatter (bodies-1,) of the ratios (d,bodies-1) about their best fit by `law` (d,p)."""
    left = ratios - law @ np.linalg.lstsq(law, ratios, rcond=None)[0]
    return np.asarray(np.sqrt(np.square(left).sum(axis=0) / max(1, len(law) - law.shape[1] + 1)))


def is_directional(ratios: Array, directions: Array, axis: Array) -> bool:
    """Whether decays that are left out one by one say that stiffness depends on the direction of bending.

    Their `ratios` (d,bodies-1) are predicted from the other decays, by a constant and by `direction_law`; the sum of
    squared errors, over each ratio's variance, must fall by GAIN. Less than DECAYS_MIN decays, or few directions,
    cannot say.
    """
    if len(ratios) < DECAYS_MIN or axis.size < 3:
        return False
    plain, law = (left_out(direction_law(directions, axis, directional=one), ratios) for one in (False, True))
    if plain is None or law is None:
        return False
    spread = np.maximum(ratios.std(axis=0), SURE)
    return bool(np.square(law / spread).sum() < (1.0 - GAIN) * np.square(plain / spread).sum())


def left_out(law: Array, ratios: Array) -> Array | None:
    """Errors (d,bodies-1) of each decay's ratios as the other decays predict them; None where those do not say."""
    hat = law @ np.linalg.pinv(law)
    own = 1.0 - np.diag(hat)
    if own.min() < DECISIVE or np.linalg.matrix_rank(law) < law.shape[1]:
        return None
    return np.asarray((ratios - hat @ ratios) / own[:, None])
