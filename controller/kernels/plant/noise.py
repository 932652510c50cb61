"""A random generator with its own state: one seed gives the same bits in the loop, in a simulation, in a replay."""

import math

import numpy as np

from controller.arrays import Pair, Seed
from controller.kernels.compiled import kernel
from controller.kernels.model.rod import sine_cosine

GOLDEN, MIX_1, MIX_2 = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
S30, S27, S31, S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@kernel
def uniform(seed: Seed) -> float:
    """Next number in (0, 1] of the splitmix64 generator whose state is `seed` (1,).

    Not in the paper: the twin's noise. In place: seed.
    """
    seed[0] += GOLDEN
    z = seed[0]
    z = (z ^ (z >> S30)) * MIX_1
    z = (z ^ (z >> S27)) * MIX_2
    z = z ^ (z >> S31)
    return (float(z >> S11) + 1.0) * 2.0**-53


@kernel
def normal_pair(seed: Seed) -> Pair:
    """Two independent standard normal numbers. Not in the paper: Box and Muller. In place: seed (1,)."""
    radius = math.sqrt(-2.0 * math.log(uniform(seed)))
    s, c = sine_cosine(2.0 * math.pi * uniform(seed))
    return radius * c, radius * s
