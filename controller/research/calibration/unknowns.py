"""What the paper leaves open, as a table: bounds, and what we believe of each number before any fit.

Reasons are the paper's text, physics and fit rows, and no other row (docs/conventions.md).
"""

import math
from typing import NamedTuple

from controller.schema.parameters import ROD_ONLY


class Unknown(NamedTuple):
    """One number of the fit. Its scale is linear, or logarithmic for what is positive and known by its order."""

    name: str
    """A field of TwinParameters ("creep.0" is its first entry, "cosserat.stiffening" one of the Cosserat plant's), or a
    gain (both axes alike)."""
    low: float
    high: float
    prior: float
    spread: float
    """Standard deviation of the prior: in the unit of the number, on a logarithmic scale of its logarithm."""
    log: bool = False

    def scaled(self, value: float) -> float:
        """`value` on the scale of the search."""
        return math.log(value) if self.log else value

    def unscaled(self, number: float) -> float:
        """Inverse of `scaled`."""
        return math.exp(number) if self.log else number

    def share(self, value: float) -> float:
        """Where `value` lies between the bounds: 0 at `low`, 1 at `high`, and for rounding errors nowhere beyond."""
        low, high = self.scaled(self.low), self.scaled(self.high)
        return min(max((self.scaled(value) - low) / (high - low), 0.0), 1.0)

    def value(self, share: float) -> float:
        """Inverse of `share`."""
        low, high = self.scaled(self.low), self.scaled(self.high)
        return min(max(self.unscaled(low + share * (high - low)), self.low), self.high)

    def surprise(self, value: float) -> float:
        """By how many standard deviations `value` is off the prior."""
        return (self.scaled(value) - self.scaled(self.prior)) / self.spread


UNKNOWNS = (
    # The model's first mode is at 0.54 Hz and goes with the root: 1.3 to 3.3 Hz. Slower, no 1 Hz circle is followed.
    Unknown("kappa", 5.0, 50.0, 15.0, 0.9, log=True),
    # Soft polymer on a sheet: it oscillates freely (paper, "logarithmic decrement"), and is not overdamped.
    Unknown("zeta", 0.1, 0.9, 0.3, 0.6, log=True),
    # The SSE of FF in the step table: a plant that bends some 10 to 20 % more than the model believes.
    Unknown("torque_gain.0", 0.8, 1.4, 1.1, 0.1),
    Unknown("torque_gain.1", 0.8, 1.4, 1.1, 0.1),
    # Two chambers of a pair are printed side by side: some percent. In the tip half more: rod 6, which sees nothing of
    # it, takes less off FF in the paper's Task 4 than where both halves are off alike, and FF's corners differ more.
    Unknown("chamber_imbalance.0", -0.3, 0.3, 0.0, 0.05),
    Unknown("chamber_imbalance.1", -0.3, 0.3, 0.0, 0.1),
    # A soft actuator does not come back quite straight: some degrees in each half.
    Unknown("set_curvature.0", -2.0, 2.0, 0.0, 0.5),
    Unknown("set_curvature.1", -2.0, 2.0, 0.0, 0.5),
    # TPU relaxes by 5 to 30 % within minutes.
    Unknown("creep.0", 0.0, 0.8, 0.15, 0.15),
    Unknown("creep.1", 0.0, 0.5, 0.1, 0.1),
    # One branch as fast as the motion, one as slow as a step: apart, so that neither takes the other's place.
    Unknown("creep_time.0", 0.05, 1.0, 0.25, 0.6, log=True),
    Unknown("creep_time.1", 1.0, 15.0, 3.5, 0.5, log=True),
    # PTFE against TPU slides at 0.05 to 0.2.
    Unknown("friction", 0.02, 0.35, 0.1, 0.05),
    # Hysteresis of printed TPU: 5 to 20 % of the torque between loading and unloading.
    Unknown("hysteresis", 0.0, 0.4, 0.1, 0.08),
    Unknown("hysteresis_bend", 0.1, 3.0, 0.5, 0.6, log=True),
    # The paper's observer has one lag of 50 ms, which its pressure steps support; inflating and exhausting are
    # on either side of it.
    Unknown("inflate_time", 0.02, 0.12, 0.05, 0.15, log=True),
    Unknown("exhaust_time", 0.02, 0.12, 0.055, 0.15, log=True),
    # FF+P leaves 11.3 of 15.7 mm in the step table: 1 / (1 + K_P) is 0.72.
    Unknown("K_P", 0.05, 1.5, 0.4, 0.5, log=True),
    # FF+I is at 1 mm after 2.7 s of each step, so faster than 1 / s.
    Unknown("K_I", 0.2, 5.0, 1.2, 0.6, log=True),
    # K_FF p_ref' is, through S, the reference K_FF seconds ahead: the paper's 50 ms of dead time and 50 ms of lag.
    Unknown("K_FF", 0.01, 0.4, 0.1, 0.6, log=True),
)

COSSERAT_UNKNOWNS = (
    *(one for one in UNKNOWNS if one.name.partition(".")[0] not in ROD_ONLY),
    # As of the twin, but what pressure stiffens is not in the gain: around what the model believes.
    Unknown("cosserat.torque_gain.0", 0.8, 1.6, 1.1, 0.15),
    Unknown("cosserat.torque_gain.1", 0.8, 1.6, 1.1, 0.15),
    Unknown("cosserat.chamber_imbalance.0", -0.3, 0.3, 0.0, 0.05),
    Unknown("cosserat.chamber_imbalance.1", -0.3, 0.3, 0.0, 0.1),
    Unknown("cosserat.set_curvature.0", -2.0, 2.0, 0.0, 0.5),
    Unknown("cosserat.set_curvature.1", -2.0, 2.0, 0.0, 0.5),
    # Pneumatic actuators of rubber stiffen by some tens of a percent over their range.
    Unknown("cosserat.stiffening", 0.0, 1.0, 0.3, 0.15),
    # Behind the lag of valves and lines, so a small part of the observer's 50 ms.
    Unknown("cosserat.lag.0", 0.001, 0.05, 0.005, 0.6, log=True),
    Unknown("cosserat.lag.1", 0.001, 0.05, 0.01, 0.6, log=True),
    # Loops of printed TPU, as of the twin: some percent of the torque.
    Unknown("cosserat.pair_hysteresis.0", 0.0, 0.1, 0.01, 0.01),
    Unknown("cosserat.pair_hysteresis.1", 0.0, 0.1, 0.015, 0.01),
)
"""The same of the Cosserat plant."""
