"""On which scale a row's number is compared with the paper's, in standard deviations of the fit."""

import math
from typing import NamedTuple

import numpy as np

from controller.arrays import Array


class Scale(NamedTuple):
    """A logarithm, or none."""

    width: float
    """Standard deviation: of the logarithm, or in the unit of the metric."""
    floor: float | None = 0.0
    """What is added before the logarithm is taken, in the unit of the metric; None: the number itself counts."""

    def place(self, numbers: Array) -> Array:
        """Where `numbers` (n,) lie on the scale."""
        return np.asarray((numbers if self.floor is None else np.log(numbers + self.floor)) / self.width)

    def numbers(self, places: Array) -> Array:
        """Inverse of `place`; an error is never below 0."""
        if self.floor is None:
            return np.asarray(self.width * places)
        return np.maximum(0.0, np.exp(self.width * places) - self.floor)


RATIO = Scale(0.1)
"""A tenth of the paper's number: of an RMSE, and of any metric that is none of these."""
SCALES = {
    # 1.0 against 1.4 mm is no news. The paper's rounding alone leaves a spread of FF+PI between 0 and 1.5 mm.
    "sse": Scale(0.3, 1.0),
    "step_spread": Scale(0.3, 1.0),
    # 15 points are the bar: one and a half deviations.
    "reduction": Scale(10.0, None),
    # It goes with the square of an RMSE.
    "ise": Scale(0.2),
    # A tenth of the swing, across it, is a tenth of a radian.
    "lag_deg_x": Scale(math.degrees(0.1), None),
    "lag_deg_y": Scale(math.degrees(0.1), None),
}


def scale_of(metric: str) -> Scale:
    """The scale of a metric."""
    return SCALES.get(metric, RATIO)
