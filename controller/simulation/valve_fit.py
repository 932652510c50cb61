"""Raw valves from steps of pressure that our own loop makes: delay, how fast they fill and exhaust; the loop's gains.

The openings that the loop asked for are those that its law makes of setpoint and reading; a chamber is taken to follow
them, `delay` later and behind a spool of first order, as an orifice fills and empties it (ISO 6358-1, choked filling):

    dp/dt = fill [o + offset]+ - exhaust [-(o + offset)]+ flow(p) / flow(EXHAUST_AT)

So the valve is fitted and not the loop around it: a loop that swings tells it as well as one that creeps. `fill`
and `exhaust` are linear, the other three are searched for; the chamber's course is compared, with soft L1 loss.

Gains: SIMC for an integrating process with dead time (S. Skogestad, "Simple analytic rules for model reduction and PID
controller tuning", J. Process Control 13, 2003, 291-309), with theta = delay + spool, for the lag tau_c that is wanted:

    gain = 1 / (k (tau_c + theta)),    integral_time = 4 (tau_c + theta)

The fit is ours, and so is what follows from air: an exhaust is faster the fuller the chamber is, so its gain is that
of EXHAUST_AT only as far as a full chamber bears it.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from controller.arrays import Array, Mask
from controller.assembly.plant import build_hardware
from controller.errors import ParameterError
from controller.kernels.plant.hardware import limited
from controller.kernels.plant.valve import ATMOSPHERE, regulate
from controller.schema.hardware import PressureLoop, Valves
from controller.simulation.lag import lagged
from controller.simulation.pneumatic_fit import ChamberSteps

SMOOTH, EVERY = 5, 4
"""Rows to either side over which a chamber counts as empty or not, and of which one is compared."""
EMPTY = 3e3
"""A chamber below this cannot empty, and tells nothing of its valve [Pa]."""
EXHAUST_AT = 60e3
"""Gauge pressure at which `exhaust` counts: of an ordinary step [Pa]."""
CRITICAL_RATIO = 0.3
"""Of pressures, below which a valve's flow is choked (ISO 6358: usual for spool valves)."""
BOUNDS_S = (0.25, 0.15, 0.03)
"""Of delay and spool [s], and of the offset either way."""
STARTS = [(delay, spool, 0.0) for delay in (0.003, 0.015, 0.05, 0.12) for spool in (0.002, 0.02)]
"""Where the search begins: the best two of these."""
SCALE = 500.0
"""What is off by less counts in full [Pa]."""
MISFIT_MOST = 0.3
"""Share of the chamber's course (rms) that may be left over."""
LAG_WANTED, LAG_PER_DELAY = 0.03, 2.0
"""The lag that the loop is to have: this [s], but this many delays at least."""
FULL_SHARE = 0.6
"""Most that gain, exhaust and theta of a full chamber multiply to: 1.57 swings, and SIMC has 0.33 at EXHAUST_AT."""
GAIN_MOST = 1e-2
"""Of the loop [1/Pa]: wholly open from an error of 100 Pa on."""
DELAY_MOST = 0.1
"""Valves later than this are refused [s]: docs/commissioning.md."""


class ValveFit(NamedTuple):
    """One chamber and its valve."""

    delay: float
    """From the loop to the valve, and from the sensor back [s]."""
    spool: float
    """Time constant of the valve itself [s]."""
    offset: float
    """Opening that no command asked for."""
    fill: float
    """Of a wholly open valve, the chamber far below the supply [Pa/s]."""
    exhaust: float
    """The same at EXHAUST_AT [Pa/s]."""
    misfit: float
    """Share of the chamber's course (rms about its mean) that is left over, carried on from its beginning."""

    @property
    def theta(self) -> float:
        """Delay and spool together [s]."""
        return self.delay + self.spool


class Margins(NamedTuple):
    """Of a linear loop: how far it is from swinging for good."""

    phase: float
    """[rad]."""
    delay: float
    """By so much more delay it would swing [s]."""


def fit_valve(steps: ChamberSteps, valves: Valves, dt: float) -> ValveFit:
    """The valve behind the loop of `valves`, whose steps were sampled every `dt` [s].

    Raises ParameterError where they do not tell it: the chamber hardly moved, or does not follow as a valve has it.
    """
    openings, shown = asked_openings(steps, valves, dt), _filled(steps.shown)
    full = np.convolve(shown, np.ones(2 * SMOOTH + 1) / (2 * SMOOTH + 1), "same") > EMPTY
    if np.ptp(shown) < 2 * EMPTY or not full.any():
        raise ParameterError(f"its pressure moved by {np.ptp(shown):.0f} Pa: too little to tell its valve")
    course = np.cumsum(np.where(full, np.diff(shown, prepend=shown[0]), 0.0))[full][::EVERY]
    regressors = _regressors(openings, exhaust_share(shown), full, dt)

    def left(x: Array) -> Array:
        A = regressors(x)
        found: Array = A @ _rates(A, course) - course
        return found

    starts = sorted(STARTS, key=lambda one: float(np.abs(left(np.array(one))).sum()))[:2]
    found = min((_search(left, start) for start in starts), key=lambda one: float(one.cost))
    A = regressors(found.x)
    fill, exhaust, _ = _rates(A, course)
    misfit = float(np.std(left(found.x)) / np.std(course))
    if misfit > MISFIT_MOST or fill <= 0.0 or exhaust <= 0.0:
        raise ParameterError(
            f"it does not follow its valve: {misfit:.0%} of its course is left over, the most is {MISFIT_MOST:.0%}"
        )
    delay, spool, offset = (float(value) for value in found.x)
    return ValveFit(delay, spool, offset, float(fill), float(exhaust), misfit)


def asked_openings(steps: ChamberSteps, valves: Valves, dt: float) -> Array:
    """Openings (n,) that the last stage of the tick made of what was asked for and shown: by its own functions."""
    hardware, shown = build_hardware(valves, dt), _filled(steps.shown)
    limit: Any = limited.py_func  # type: ignore[attr-defined]  # a compiled call costs more than what it saves
    law: Any = regulate.py_func  # type: ignore[attr-defined]
    p_set, integral, found = float(steps.asked[0]), 0.0, np.zeros(len(shown))
    for row, (wanted, p) in enumerate(zip(steps.asked.tolist(), shown.tolist(), strict=True)):
        p_set = limit(wanted, p_set, hardware)
        found[row], integral = law(hardware.loop, p_set - p, integral, dt)
    return found


def tuned_loop(fits: Sequence[ValveFit], pressure_max: float) -> PressureLoop:
    """Gains for all chambers: of the fastest and the latest of them; `pressure_max` [Pa] is the fullest they get.

    Raises ParameterError where a valve is later than DELAY_MOST.
    """
    theta = max(one.theta for one in fits)
    if theta > DELAY_MOST:
        raise ParameterError(
            f"the valves answer after {theta * 1e3:.0f} ms (delay and spool), at most {DELAY_MOST * 1e3:.0f} ms: "
            "use valves that hold pressures themselves, or bring board and valves nearer"
        )
    slow = max(LAG_WANTED, LAG_PER_DELAY * theta) + theta
    exhaust = max(one.exhaust for one in fits)
    full = exhaust * float(exhaust_share(np.array(pressure_max)))
    return PressureLoop(
        inflate_gain=_rounded(1.0 / (max(one.fill for one in fits) * slow)),
        exhaust_gain=_rounded(min(1.0 / (exhaust * slow), FULL_SHARE / (full * max(theta, LAG_WANTED / 3.0)))),
        integral_time=float(f"{4.0 * slow:.3g}"),
    )


def worst_margins(loop: PressureLoop, fits: Sequence[ValveFit], pressure_max: float) -> Margins:
    """Of all chambers, filling and exhausting, at pressures from 5 kPa to `pressure_max` [Pa]: the smallest of each."""
    shares = exhaust_share(np.linspace(5e3, pressure_max, 12)).tolist()
    integral = loop.inflate_gain / loop.integral_time
    found = [
        margins(gain, integral, k, one)
        for one in fits
        for gain, ks in (
            (loop.inflate_gain, [one.fill]),
            (loop.exhaust_gain, [one.exhaust * share for share in shares]),
        )
        for k in ks
    ]
    return Margins(min(one.phase for one in found), min(one.delay for one in found))


def margins(gain: float, integral: float, k: float, valve: ValveFit) -> Margins:
    """Of (gain + integral / s) k exp(-delay s) / (s (spool s + 1)) where its size is 1."""

    def size(omega: float) -> float:
        return k * math.hypot(gain * omega, integral) / (omega**2 * math.hypot(1.0, valve.spool * omega))

    low, high = 1e-3, 1e5
    for _ in range(80):  # it falls from one end to the other
        middle = math.sqrt(low * high)
        low, high = (middle, high) if size(middle) > 1.0 else (low, middle)
    phase = math.atan2(gain * low, integral) - valve.delay * low - math.atan(valve.spool * low)
    return Margins(phase, phase / low)


def exhaust_share(p: Array) -> Array:
    """Flow out of a chamber at gauge pressures p [Pa], as a share of that at EXHAUST_AT."""
    found: Array = _exhaust(p) / _exhaust(np.array(EXHAUST_AT))
    return found


def _exhaust(p: Array) -> Array:
    """Flow out of an open valve by ISO 6358, up to a factor."""
    up = np.maximum(p, 0.0) + ATMOSPHERE
    s = np.clip((ATMOSPHERE / up - CRITICAL_RATIO) / (1.0 - CRITICAL_RATIO), 0.0, 1.0)
    found: Array = up * np.sqrt(1.0 - s * s)
    return found


def _filled(shown: Array) -> Array:
    """Readings (n,) with the gaps bridged."""
    seen = np.isfinite(shown)
    if not seen.any():
        raise ParameterError("its pressure was not measured")
    rows = np.arange(len(shown))
    found: Array = np.interp(rows, rows[seen], shown[seen])
    return found


def _regressors(openings: Array, share: Array, full: Mask, dt: float) -> Callable[[Array], Array]:
    """By (delay, spool, offset): what rates of 1 Pa/s would have filled and emptied by each row (m,3) [Pa], and 1."""
    rows = np.arange(len(openings), dtype=float)

    def regressors(x: Array) -> Array:
        late = np.interp(rows - x[0] / dt, rows, openings)
        keep = math.exp(-dt / x[1]) if x[1] > 1e-6 else 0.0
        spool = lagged(late, keep, late[:1]) + x[2]
        ways = np.column_stack((np.clip(spool, 0.0, 1.0), np.clip(spool, -1.0, 0.0) * share))
        sums = np.cumsum(np.where(full[:, None], ways, 0.0), axis=0)[full][::EVERY] * dt
        found: Array = np.column_stack((sums, np.ones(len(sums))))
        return found

    return regressors


def _rates(A: Array, course: Array) -> Array:
    return np.asarray(np.linalg.lstsq(A, course, rcond=None)[0], np.float64)


def _search(left: Callable[[Array], Array], start: Sequence[float]) -> Any:
    least = np.array([0.0, 0.0, -BOUNDS_S[2]])
    return least_squares(
        left,
        np.clip(start, least + 1e-6, np.array(BOUNDS_S) - 1e-6),
        bounds=(least, BOUNDS_S),
        loss="soft_l1",
        f_scale=SCALE,
        x_scale=(0.01, 0.01, 0.003),
        diff_step=[1e-3] * 3,
        xtol=1e-7,
        ftol=1e-9,
    )


def _rounded(value: float) -> float:
    return float(f"{min(value, GAIN_MOST):.3g}")
