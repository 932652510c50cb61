"""Non-linear least squares with confidence intervals, of unknowns or, for what must stay positive, logarithms."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.fit import Estimate

CONFIDENCE = 0.95


class Solution(NamedTuple):
    """Unknowns (p,), their covariance (p,p) and half-widths of their confidence intervals per standard error."""

    x: Array
    covariance: Array
    t: float
    residual: Array


def solve(residual: Callable[[Array], Array], start: Array, *, robust: bool) -> Solution:
    """Least squares with the covariance s^2 (J^T J)^-1; DataError where the data leave an unknown free.

    The robust solution starts from the plain one, and its covariance is Huber's H^-1 (J^T J) H^-1 times the variance of
    what each value still pulls with; both are the same where no value lies far out.
    """
    found = least_squares(residual, start, x_scale=0.1)
    J = _jacobian(residual, found.x)
    rows, columns = J.shape
    if rows <= columns or np.linalg.matrix_rank(J) < columns:
        raise DataError(f"{rows} measured values do not determine {columns} unknowns")
    pull, hessian = found.fun, J.T @ J
    if robust:
        scale = max(spread(found.fun), 1e-9)
        found = least_squares(residual, found.x, x_scale=0.1, loss="soft_l1", f_scale=scale)
        J = _jacobian(residual, found.x)
        bent = 1.0 + np.square(found.fun / scale)
        pull, hessian = found.fun / np.sqrt(bent), J.T * bent**-1.5 @ J
    inverse = np.linalg.inv(hessian)
    covariance = inverse @ (J.T @ J) @ inverse * float(pull @ pull) / (rows - columns)
    return Solution(found.x, covariance, float(stats.t.ppf((1 + CONFIDENCE) / 2, rows - columns)), found.fun)


def _jacobian(residual: Callable[[Array], Array], x: Array, h: float = 1e-5) -> Array:
    """Central differences (n,p)."""
    return np.stack([(residual(x + step) - residual(x - step)) / (2 * h) for step in h * np.eye(x.size)], axis=1)


def spread(residual: Array) -> float:
    """Standard deviation of the bulk, whatever the outliers."""
    return float(np.median(np.abs(residual))) / 0.6745


def plain(name: str, unit: str, solution: Solution, direction: Array) -> Estimate:
    """A sum of unknowns itself, with its interval."""
    middle = float(direction @ solution.x)
    half = solution.t * float(np.sqrt(direction @ solution.covariance @ direction))
    return Estimate(name, middle, middle - half, middle + half, unit)


def exponential(name: str, unit: str, solution: Solution, direction: Array) -> Estimate:
    """The exponential of a sum of unknowns, with its interval."""
    middle = float(direction @ solution.x)
    half = solution.t * float(np.sqrt(direction @ solution.covariance @ direction))
    return Estimate(name, float(np.exp(middle)), float(np.exp(middle - half)), float(np.exp(middle + half)), unit)
