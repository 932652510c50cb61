"""The arm's first mode from small steps of its pressures: its frequency, its damping ratio, and kappa.

The tip, along the line on which it moves most, is taken as a mode y that the measured torques drive, a share that
follows them at once (all higher modes), and an even drift (creep):

    y'' + 2 zeta omega y' + omega^2 (y + F - q) = 0,    s = c_0 + c_1 t + c_2 q + c_3 y

q is where the torques would hold the model's tip, `delay` earlier: the input is what the chambers had, so neither dead
time nor lag nor the valves count. F is dry friction, F_max at most and either way, which builds up over SLIP (as on the
twin's sheet): a viscous damper in its place would be said to be twice as strong. omega, zeta, F_max and delay are those
of all steps; c is each step's own, by linear least squares (variable projection). Ours: the paper measures no damping.
"""

import math
from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Mask, Words
from controller.assembly.stability import undamped
from controller.assembly.twin import twin_model
from controller.errors import ParameterError
from controller.kernels.compiled import kernel
from controller.schema.parameters import RigParameters

SLIP = 1e-3
"""Way of the tip over which friction builds up and turns round [m]."""
LOWEST, HIGHEST = 0.3, 20.0
"""Frequencies that are looked for [Hz]."""
STARTS = (1.5, 4.0)
"""Where the search begins [Hz]."""
ZETA_MOST = 2.0
FRICTION_MOST = 0.03
"""Shift of the rest [m]."""
DELAYS = (-0.02, 0.06)
"""Of the tip behind the torques [s]: age of the samples, lag between chamber and torque."""
MOVED_LEAST = 0.01
"""The tip must move by this at least [m]."""
MISFIT_MOST = 0.2
"""Share of the motion (rms) that may be left over."""
SWINGS_BELOW = 1.0
"""From this damping ratio on nothing swings, and frequency and damping cannot be told apart."""
PRESSURES_LEAST = 0.3
"""Measured pressures that move by less than this share of what was sent are none."""
SAMPLES_LEAST = 20
"""Of the tip in each step."""
TORQUE_MOST = 0.5
"""Steps stay within this share of u_max."""
CONFIDENCE = 0.95


class ModeModel(NamedTuple):
    """What the model says of the first mode at rest, before kappa."""

    omega: float
    """Undamped frequency at kappa = 1 [rad/s]."""
    S: Array
    """Way of the tip by the torques (2,2) [m/(N m)]."""

    def kappa(self, frequency: float) -> float:
        """By which stiffness, torque and gravity of the twin are to be multiplied for `frequency`, undamped [Hz]."""
        return float((2.0 * math.pi * frequency / self.omega) ** 2)


class StepRecord(NamedTuple):
    """What was measured: rows of the loop, evenly spaced."""

    dt: float
    """[s]."""
    torque: Array
    """In the chambers (n,2) [N m]; see `driving_torque`."""
    tip: Array
    """Held between samples (n,2) [m]; nan where its marker was not seen."""
    starts: tuple[int, ...]
    """Rows at which the steps begin, there and back in turn; the last one goes on to the end."""


class Estimate(NamedTuple):
    """A number with its 95 % interval over the repeats."""

    value: float
    low: float
    high: float


class FirstMode(NamedTuple):
    """What was found."""

    frequency: Estimate
    """Undamped [Hz]."""
    zeta: Estimate
    kappa: Estimate
    """`ModeModel.kappa` of this frequency."""
    friction: float
    """By how much dry friction shifts the rest, either way [m]."""
    delay: float
    """[s]."""
    misfit: float
    """Share of the motion (rms) that is left over."""


class _Step(NamedTuple):
    """The samples of one step, along the line of motion."""

    at: Words
    """Rows of the record (m,)."""
    s: Array
    """The tip there (m,) [m]."""


class _Motion(NamedTuple):
    """All that is fitted to; the mode goes on from one step to the next, as it may not have come to rest."""

    dt: float
    q: Array
    """From the first row of the record (n,) [m]; 0 there."""
    steps: list[_Step]


def mode_model(parameters: RigParameters) -> ModeModel:
    """Of the chain that stands for the plant (`tendril stability`); ParameterError where it cannot be built."""
    model = twin_model(parameters.actuator, parameters.twin.model_copy(update={"kappa": 1.0}))
    turn = model.L * np.array([-np.sin(model.rest), np.cos(model.rest)])
    return ModeModel(float(undamped(model)[0]), turn @ model.compliance)


def step_torque(travel: float, parameters: RigParameters) -> float:
    """Torque of both pairs [N m] that takes the model's tip by half of `travel` [m] to either side of its rest.

    Raises ParameterError where that is beyond what small steps may take.
    """
    way = float(np.linalg.norm(mode_model(parameters).S.sum(axis=1)))
    most = TORQUE_MOST * parameters.actuator.u_max
    if travel > 2.0 * most * way:
        raise ParameterError(f"travel = {travel:g} m is more than {2.0 * most * way:.3g}, which half of u_max makes")
    return travel / (2.0 * way)


def driving_torque(pressure: Array, sent: Array, parameters: RigParameters) -> tuple[Array, bool]:
    """Torques (n,2) [N m] of the measured pressures (n,4) [Pa], and True; where none are measured, `sent`, and False.

    `sent` (n,2) [N m]: the observer's delayed and lagged input.
    """
    torque = pressure / parameters.actuator.chamber_slopes
    found = torque[:, ::2] - torque[:, 1::2]
    follow = np.ptp(found, axis=0) >= PRESSURES_LEAST * np.ptp(sent, axis=0)
    return (found, True) if np.isfinite(found).all() and follow.all() else (sent, False)


def first_mode(record: StepRecord, model: ModeModel) -> FirstMode:
    """Frequency, damping ratio and kappa; ParameterError with the reason where the record does not tell them."""
    motion = _motion(record, model)
    found, misfit = _fitted(motion)
    if misfit > MISFIT_MOST:
        raise ParameterError(
            f"the tip does not move as one damped mode: {misfit:.0%} of its motion is left over, the most is "
            f"{MISFIT_MOST:.0%}"
        )
    if found[1] >= SWINGS_BELOW:
        raise ParameterError(f"the tip does not swing: its damping ratio is {found[1]:.2g}, 1 or more")
    repeats = [motion._replace(steps=motion.steps[i : i + 2]) for i in range(0, len(motion.steps), 2)]
    each = np.array([_fitted(one, found)[0] for one in repeats])
    frequency = _estimate(found[0], each[:, 0])
    return FirstMode(
        frequency=frequency,
        zeta=_estimate(found[1], each[:, 1]),
        kappa=Estimate(*(model.kappa(f) for f in frequency)),
        friction=float(found[2]),
        delay=float(found[3]),
        misfit=misfit,
    )


def mode_response(q: Array, omega: float, zeta: float, friction: float, dt: float) -> Array:
    """The mode y (n,) [m] that q (n,) [m] drives from rest, by symplectic steps of dt [s]; `friction` F_max [m]."""
    y = np.zeros(q.size)
    respond(q, omega, zeta, friction, dt, y)
    return y


@kernel
def respond(q: Array, omega: float, zeta: float, friction: float, dt: float, out_y: Array) -> None:
    """What `mode_response` gives, into out_y (n,) [m]. Not in the paper, which measures no damping."""
    stiff, loss, rub = omega * omega * dt, zeta * omega * dt, friction / SLIP
    at = rate = held = 0.0
    for i in range(q.size):
        rate = ((1.0 - loss) * rate + stiff * (q[i] - at - rub * held)) / (1.0 + loss)
        way = rate * dt
        at += way
        held = min(max(held + way, -SLIP), SLIP)
        out_y[i] = at


def _motion(record: StepRecord, model: ModeModel) -> _Motion:
    seen = np.isfinite(record.tip).all(axis=1)
    if seen.sum() < 2:
        raise ParameterError("the tip was not seen")
    centred = record.tip[seen] - record.tip[seen].mean(axis=0)
    line = np.linalg.svd(centred, full_matrices=False)[2][0]
    s, q = record.tip @ line, record.torque @ (model.S.T @ line)
    moved = float(np.ptp(s[seen]))
    if moved < MOVED_LEAST:
        raise ParameterError(f"the tip moved by {1e3 * moved:.1f} mm, less than {1e3 * MOVED_LEAST:g} mm: too little")
    fresh = seen & _changed(record.tip)
    ends = (*record.starts[1:], len(s))
    spans = [a + np.flatnonzero(fresh[a:b]) for a, b in zip(record.starts, ends, strict=True)]
    if (fewest := min(at.size for at in spans)) < SAMPLES_LEAST:
        raise ParameterError(f"a step has {fewest} samples of the tip, less than {SAMPLES_LEAST}")
    return _Motion(record.dt, q - q[0], [_Step(at, s[at]) for at in spans])


def _changed(tip: Array) -> Mask:
    """Where a new sample came (n,)."""
    return np.concatenate([[False], (np.diff(tip, axis=0) != 0.0).any(axis=1)])


def _fitted(motion: _Motion, start: Array | None = None) -> tuple[Array, float]:
    """Frequency [Hz], zeta, friction [m] and delay [s] (4,) that fit best, and the share that is left over.

    The search begins at `start` (4,), or at each of STARTS.
    """
    from scipy.optimize import least_squares  # not for a start of the server

    begin = [start] if start is not None else [np.array([f, 0.2, 1e-3, 0.01]) for f in STARTS]
    low, high = (LOWEST, 0.0, 0.0, DELAYS[0]), (HIGHEST, ZETA_MOST, FRICTION_MOST, DELAYS[1])
    inside = [np.clip(x, np.array(low) + 1e-9, np.array(high) - 1e-9) for x in begin]
    found = [
        least_squares(_left_over, x, args=(motion,), bounds=(low, high), x_scale=(0.3, 0.1, 1e-3, 0.01), xtol=1e-5)
        for x in inside
    ]
    best = min(found, key=lambda one: float(one.cost))
    moved = np.concatenate([step.s - step.s.mean() for step in motion.steps])
    return np.asarray(best.x), math.sqrt(2.0 * float(best.cost) / float(moved @ moved))


def _left_over(x: Array, motion: _Motion) -> Array:
    """What of all samples [m] the parameters x (4,) do not explain, each step with the best c."""
    end = int(motion.steps[-1].at[-1]) + 1
    rows = np.arange(end, dtype=np.float64)
    q = np.interp(rows - x[3] / motion.dt, rows, motion.q[:end])
    y = mode_response(q, 2.0 * math.pi * x[0], x[1], x[2], motion.dt)
    return np.concatenate([_unexplained(step, q, y, motion.dt) for step in motion.steps])


def _unexplained(step: _Step, q: Array, y: Array, dt: float) -> Array:
    """Of one step's samples (m,) [m]."""
    at = step.at
    basis = np.column_stack([np.ones(at.size), dt * (at - at[0]), q[at], y[at]])
    return np.asarray(basis @ np.linalg.lstsq(basis, step.s, rcond=None)[0] - step.s)


def _estimate(value: float, each: Array) -> Estimate:
    """`value`, which is not negative, with Student's interval of the mean of `each` (n,), n > 1."""
    from scipy.stats import t

    count = each.size
    half = float(t.ppf((1.0 + CONFIDENCE) / 2.0, count - 1)) * float(each.std(ddof=1)) / math.sqrt(count)
    return Estimate(float(value), max(0.0, float(value) - half), float(value) + half)
