"""Other prints of an actuator: the flaws of its making are drawn again from what is believed of them.

The fit is P1's. What of it is the material's, the sheet's or the valves' holds for P2 and P3 as well; how far off its
chambers and its rest are is each print's own (docs/conventions.md).
"""

import numpy as np

from controller.arrays import Array
from controller.research.calibration.space import Space
from controller.research.calibration.unknowns import Unknown

FITTED_PRINT = "P1"
"""The actuator whose flaws the fit has."""
FLAWS = ("torque_gain", "chamber_imbalance", "set_curvature")
"""Fields of the twin, or of the Cosserat plant, that are a print's own."""


def is_flaw(unknown: Unknown) -> bool:
    """Whether each print has this number of its own."""
    return bool(set(unknown.name.split(".")) & set(FLAWS))


def another_print(space: Space, z: Array, seed: tuple[int, ...]) -> Array:
    """z (n,) with the flaws drawn from their priors, within the bounds; the same `seed` draws the same print."""
    off = np.random.default_rng(seed).standard_normal(len(space.unknowns))
    drawn = space.off_priors(off)
    return np.where([is_flaw(one) for one in space.unknowns], drawn, z)
