"""The loop of plant, camera, observer, feedback and air lines as matrices, one for each tick between two samples.

Linear about a pose in which everything rests: the feedforward stands still, S is that of the pose, nothing saturates.
The plant is the twin's chain with the lag of a small step in place of its valves. Rates of several clocks meet, so what
counts is the product of the matrices over one period of the camera.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import ArpackError, eigs

from controller.arrays import Array, Mask, Values
from controller.kernels.observer.alpha_beta import beta_of
from controller.research.stability.chain_step import ChainStep
from controller.schema.parameters import Settings

FROZEN = 1e-6
"""A direction of which less than this share is let through: nothing is fed back and nothing collected along it."""
SWINGS = 1.0
"""What turns by more than this is a swing, what turns less a drift [rad/s]."""
STEADY = 1.0 + 1e-7
"""Growth of swings per tick up to this is none: differences are right to some 1e-9."""
DRIFT = 1.0 + 1e-4
"""A drift that grows more slowly than this in a tick is no instability: e-fold in 10 s, at 1 kHz. At the edges of the
reach, where S changes its sign between model and plant, there is some at a hundredth of that."""

LARGE = 150
"""From this size on a matrix is large."""
LARGEST_COUNT = 20
"""Eigenvalues that are looked for in it: more than an arm has slow ones."""
TOLERANCE = 1e-12


class Growth(NamedTuple):
    """Largest moduli per tick."""

    all: float
    swings: float

    @property
    def stable(self) -> bool:
        """Whether no swing grows, and no drift but a slow one."""
        return self.swings <= STEADY and self.all <= DRIFT


@dataclass(frozen=True)
class Timing:
    """What the loop's ticks are counted in."""

    dt: float
    """[s]."""
    period: int
    """Ticks between two samples."""
    latency: int
    """Ticks until a sample is there, less than the period."""
    observer_delay: int
    """Ticks of dead time in the observer."""
    plant_delay: int
    """The same in the plant."""
    observer_lag: float
    """Time constant [s]."""
    plant_lag: float
    """[s]."""
    carried: bool
    """Whether the observer carries samples on."""
    alpha: float | None
    """Of the filter of what its model does not explain of them; None where they are carried on by themselves."""


class ByHand(NamedTuple):
    """How the law differs where the tip is led by hand, as in `kernels/control/feedback.py`."""

    lag: float
    """Time constant with which P follows the error [s]."""
    told: float
    """Share of P and I that the markers are worth."""


LIBRARY = ByHand(0.0, 1.0)
"""On the library's shapes it does not."""


class Feedback(NamedTuple):
    """The law at one pose."""

    to_torque: Array
    """(S^T S + epsilon I)^-1 S^T with what is faded left out (2,2): u_fb = to_torque f_des [N m/m]."""
    through: Array
    """What of an error is collected (2,2)."""
    K_P: Array
    """(2,)."""
    K_I: Array
    """(2,) [1/s]."""
    lag: float
    """Time constant with which P follows the error [s]."""


class Chains(NamedTuple):
    """The three, about one pose."""

    observer: ChainStep
    """Its P is of the tip alone."""
    free: ChainStep
    """The observer's model that the torques alone move."""
    plant: ChainStep


class Loop:
    """The matrices of one pose; `growth` for any factor on the plant's torque and any more dead time."""

    def __init__(self, chains: Chains, law: Feedback, tip: int | None, timing: Timing) -> None:
        """`tip`: which of the measured points the error is taken from; with None it is the observer's tip."""
        self._observer, self._free, self._plant = chains
        self._law, self._tip, self._timing = law, tip, timing

    def growth(self, factor: complex = 1.0, more_delay: int = 0) -> Growth:
        """With the torque that reaches the plant times `factor`, and later by `more_delay` ticks."""
        timing = self._timing
        whole = self._tick(0, factor, more_delay)
        for k in range(1, timing.period):
            whole = self._tick(k, factor, more_delay) @ whole
        slowest = SWINGS * timing.period * timing.dt
        found = largest_eigenvalues(whole)
        if not swinging(found, slowest).any():
            found = np.linalg.eigvals(whole)
        a_tick = np.abs(found) ** (1.0 / timing.period)
        return Growth(float(a_tick.max()), float(a_tick[swinging(found, slowest)].max(initial=0.0)))

    def _tick(self, k: int, factor: complex, more_delay: int) -> Array:
        """The tick that comes k ticks after a sample was taken: sense, observe, feed back, then the plant moves on."""
        timing, law, observer, plant = self._timing, self._law, self._observer, self._plant
        at = _places(self._sizes(more_delay))
        new = np.eye(at["end"].stop, dtype=complex if isinstance(factor, complex) else float)
        here = new.copy()
        late = here[_slot(at, timing.observer_delay)]
        new[at["u_hat"]] += _step(timing.dt, timing.observer_lag) * (late - here[at["u_hat"]])
        p, v = self._markers(k, here, new, at)
        new[at["observer"]] = (
            observer.A @ here[at["observer"]] + observer.B_u @ new[at["u_hat"]] + observer.B_p @ p + observer.B_v @ v
        )
        error = -self._seen(new, at)
        new[at["integral"]] = _kept(law) @ here[at["integral"]] + timing.dt * law.through @ error
        new[at["low"]] += timing.dt / (law.lag + timing.dt) * (error - here[at["low"]])
        u = law.to_torque @ (law.K_P[:, None] * new[at["low"]] + law.K_I[:, None] * here[at["integral"]])
        if k == 0:
            new[at["taken"]] = plant.P @ here[at["plant"]]
        delay = timing.plant_delay + more_delay
        late = u if delay == 0 else here[_slot(at, delay - 1)]
        new[at["u_lag"]] += _step(timing.dt, timing.plant_lag) * (late - here[at["u_lag"]])
        new[at["plant"]] = plant.A @ here[at["plant"]] + factor * (plant.B_u @ new[at["u_lag"]])
        line = at["line"]
        new[line.start + 2 : line.stop] = here[line.start : line.stop - 2]
        new[line.start : line.start + 2] = u
        return new

    def _markers(self, k: int, here: Array, new: Array, at: dict[str, slice]) -> tuple[Array, Array]:
        """Where the observer holds the markers to be in the middle of its step, and how fast (n,). In place: new."""
        timing, free = self._timing, self._free
        apart, arrives = timing.period * timing.dt, k == (timing.latency + 1) % timing.period
        age = (k if k > timing.latency else k + timing.period) * timing.dt
        if arrives:
            new[at["p"]] = here[at["taken"]]
        if timing.alpha is None:
            if arrives:
                new[at["v"]] = (here[at["taken"]] - here[at["p"]]) / apart
            ahead = age + 0.5 * timing.dt if timing.carried else 0.0
            return new[at["p"]] + ahead * new[at["v"]], new[at["v"]]
        new[at["free"]] = free.A @ here[at["free"]] + free.B_u @ new[at["u_hat"]]
        before, after = free.P @ here[at["free"]], free.P @ new[at["free"]]
        if arrives:
            innovation = here[at["taken"]] - here[at["free_taken"]] - here[at["off"]] - apart * here[at["v"]]
            new[at["off"]] += apart * here[at["v"]] + timing.alpha * innovation
            new[at["v"]] += beta_of(timing.alpha) / apart * innovation
        if k == 0:
            new[at["free_taken"]] = after
        p = 0.5 * (before + after) + new[at["off"]] + (age - 0.5 * timing.dt) * new[at["v"]]
        return p, (after - before) / timing.dt + new[at["v"]]

    def _seen(self, state: Array, at: dict[str, slice]) -> Array:
        """The tip, as the feedback sees it (2,n)."""
        if self._tip is None:
            return np.asarray(self._observer.P @ state[at["observer"]])
        return np.asarray(state[at["p"]][2 * self._tip : 2 * self._tip + 2])

    def _sizes(self, more_delay: int) -> dict[str, int]:
        points, timing = self._plant.P.shape[0], self._timing
        filtered = 0 if timing.alpha is None else points
        line = 2 * (max(timing.observer_delay, timing.plant_delay + more_delay) + 1)
        return {
            "plant": self._plant.A.shape[0],
            "u_lag": 2,
            "taken": points,
            "p": points,
            "v": points,
            "free": self._free.A.shape[0] if filtered else 0,
            "free_taken": filtered,
            "off": filtered,
            "observer": self._observer.A.shape[0],
            "u_hat": 2,
            "integral": 2,
            "low": 2,
            "line": line,
            "end": 0,
        }


def largest_eigenvalues(A: Values) -> Values:
    """Those of largest modulus of A (n,n): all of a small matrix, of a large one LARGEST_COUNT by Arnoldi's method.

    Most of a large one is dead time, whose hundreds of small eigenvalues take five sixths of the time.
    """
    if A.shape[0] < LARGE:
        return np.linalg.eigvals(A)
    start = np.random.default_rng(0).standard_normal(A.shape[0]).astype(A.dtype)
    try:
        return np.asarray(
            eigs(A, k=LARGEST_COUNT, ncv=3 * LARGEST_COUNT, tol=TOLERANCE, v0=start, return_eigenvectors=False)
        )
    except ArpackError:
        return np.linalg.eigvals(A)


def swinging(found: Values, slowest: float) -> Mask:
    """Which eigenvalues turn by more than `slowest` [rad] in a period."""
    return np.asarray(np.abs(np.angle(found)) > slowest)


def feedback(S: Array, share: float, weak: Array, settings: Settings, epsilon: float, by_hand: ByHand) -> Feedback:
    """The law at a pose with sensitivity S (2,2): `share` is let through along `weak` (2,).

    Eq. UFB: paper, "Task-space PI control".
    """
    through = np.eye(2) - (1.0 - share) * np.outer(weak, weak)
    to_torque = np.linalg.solve(S.T @ S + epsilon * np.eye(2), S.T) @ through
    K_P, K_I = by_hand.told * np.array(settings.K_P), by_hand.told * np.array(settings.K_I)
    return Feedback(to_torque, through, K_P, K_I, by_hand.lag)


def _places(sizes: dict[str, int]) -> dict[str, slice]:
    ends = np.cumsum([0, *sizes.values()])
    return {name: slice(int(a), int(b)) for name, a, b in zip(sizes, ends[:-1], ends[1:], strict=True)}


def _slot(at: dict[str, slice], ticks: int) -> slice:
    """The torques sent `ticks` ticks before the last ones."""
    start = at["line"].start + 2 * ticks
    return slice(start, start + 2)


def _step(dt: float, lag: float) -> float:
    return 1.0 - math.exp(-dt / lag)


def _kept(law: Feedback) -> Array:
    """What of the integral is a state: along a direction in which nothing is let through it stands still for ever."""
    values, vectors = np.linalg.eigh(law.through)
    return np.asarray(vectors @ np.diag((values > FROZEN).astype(float)) @ vectors.T)
