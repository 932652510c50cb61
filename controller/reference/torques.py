"""Torques that move the nominal model along a reference: through dead time, lag, inertia and damping.

The run is planned as it would be learned: the model follows it, what is left of the error is led back through the
inverse of what is late in the model, and added to the torques; some ten runs of the model, a second of processor. That
is Gauss-Newton on the whole run with the slope of tip by torques taken as S of the pose at hand, times the first
mode's, the chambers' and the lines' response, which have one inverse for all times:
    L(s) = (1 + 2 zeta s / omega + s^2 / omega^2) (1 + tau s) e^{t_d s} Q(s).
Q lets through what is slower than a cutoff, forward and backward in time alike. Where a step does not lead closer, the
cutoff falls: where S, or the mode, is not what it was taken for, quick corrections are wrong before slow ones are.
Bristow, Tharayil, Alleyne, "A survey of iterative learning control", IEEE Control Systems Magazine 26 (2006).
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.fft

from controller.arrays import Array
from controller.assembly.rig import free_model
from controller.assembly.stability import slowest
from controller.assembly.statics import planning_model, scratch_for, static_map
from controller.kernels.model.statics import pose, static_pose
from controller.kernels.observer.foreseen import foresee_tip, move_torques
from controller.kernels.observer.observer import Observer
from controller.reference.feasible.within_reach import projected
from controller.schema.actuator import Actuator
from controller.schema.parameters import ControllerParameters
from controller.system.progress import ProgressCallback, no_progress

CUTOFF_HZ, CUTOFF_LEAST_HZ = 4.0, 0.7
"""Q lets through half at the cutoff; where it has fallen to the least nothing more is to be gained."""
FALLS = 0.75
"""By what the cutoff is multiplied after a step that did not lead closer."""
ROUNDS = 12
"""Runs of the model."""
CLOSER = 0.995
"""A step leads closer if less than this share of the error is left."""
ORDER = 8
"""How steeply Q falls, as of a Butterworth filter of half the order, forward and backward."""
WEAK = 0.05
"""A direction in which S is weaker than this share of its strongest is left alone."""
PAD_S = 1.0
"""The run stands still for as long before and after, as it is filtered."""


class Late(NamedTuple):
    """What is late in the model, about its rest."""

    omega: float
    """Of the first mode [rad/s]."""
    zeta: float
    tau: float
    """Of the chambers [s]."""
    dead_time: float
    """Of the lines [s]."""
    dt: float
    """[s]"""


def planned_torques(
    actuator: Actuator,
    controller: ControllerParameters,
    p: Array,
    u: Array | None,
    told: ProgressCallback = no_progress,
) -> Array:
    """(n,2) [N m]: torques that lead the model's tip along p (n,2) [m], which it begins at rest.

    u (n,2) [N m] holds the points; without it the branch is that of the loop's own inverse.
    """
    given = None if u is None else u.tobytes()
    return _planned(actuator, controller, p.tobytes(), given, told)


def foreseen(actuator: Actuator, controller: ControllerParameters, u: Array) -> Array:
    """(n,2) [m]: where the model's tip is as each of the torques u (n,2) [N m] is sent, at rest under the first."""
    p = np.zeros_like(u)
    foresee_tip(u, _resting(actuator, controller, u[0]), p)
    return p


@lru_cache(maxsize=16)
def _planned(
    actuator: Actuator, controller: ControllerParameters, p: bytes, u: bytes | None, told: ProgressCallback
) -> Array:
    wanted = np.frombuffer(p).reshape(-1, 2)
    smap = static_map(actuator, controller)
    held = projected(smap, wanted).u if u is None else np.frombuffer(u).reshape(-1, 2)
    late, scratch, cutoff = late_of(actuator, controller), scratch_for(smap), CUTOFF_HZ
    best = np.ascontiguousarray(led_back(held, late, cutoff))
    move_torques(np.zeros_like(best), WEAK, smap, scratch, best)
    error = wanted - foreseen(actuator, controller, best)
    for n in range(ROUNDS):
        if cutoff < CUTOFF_LEAST_HZ:
            break
        tried = best.copy()
        move_torques(led_back(error, late, cutoff), WEAK, smap, scratch, tried)
        left = wanted - foreseen(actuator, controller, tried)
        if np.sum(left**2) < CLOSER**2 * np.sum(error**2):
            best, error = tried, left
        else:
            cutoff *= FALLS
        told((n + 1) / ROUNDS)
    best.flags.writeable = False
    return best


def led_back(x: Array, late: Late, cutoff: float) -> Array:
    """What has to be asked for x (n,2) to come out: L of the module, for x that stands still before and after."""

    def inverse(f: Array) -> Array:
        s = 2j * np.pi * f
        mode = 1.0 + 2.0 * late.zeta * s / late.omega + (s / late.omega) ** 2
        return np.asarray(mode * (1.0 + late.tau * s) * np.exp(s * late.dead_time) * slow(f, cutoff))

    return filtered(x, late.dt, inverse)


def slow(f: Array, cutoff: float) -> Array:
    """Q of the module at the frequencies f [Hz]: what is slower than the cutoff [Hz], of which half is let through."""
    return np.asarray(1.0 / (1.0 + (f / cutoff) ** ORDER))


def filtered(x: Array, dt: float, response: Callable[[Array], Array]) -> Array:
    """x (n,2), rows dt [s] apart, by its response at each frequency [Hz]; it stands still before and after.

    Forward and backward in time alike, where the response is real.
    """
    pad = round(PAD_S / dt)
    size = scipy.fft.next_fast_len(len(x) + 2 * pad, real=True)
    whole = np.pad(x, ((pad, size - len(x) - pad), (0, 0)), mode="edge")
    line = whole[0] + np.linspace(0.0, 1.0, size)[:, None] * (whole[-1] - whole[0])
    spectrum = scipy.fft.rfft(whole - line, axis=0) * response(scipy.fft.rfftfreq(size, dt))[:, None]
    return np.asarray((scipy.fft.irfft(spectrum, size, axis=0) + line)[pad : pad + len(x)])


def late_of(actuator: Actuator, controller: ControllerParameters) -> Late:
    """Of the nominal model."""
    omega, zeta = slowest(planning_model(actuator, controller))
    return Late(omega, zeta, controller.pneumatic_lag, controller.dead_time, controller.dt)


def _resting(actuator: Actuator, controller: ControllerParameters, u: Array) -> Observer:
    """The model at rest under the torques u (2,) [N m], which fill its lines."""
    smap = static_map(actuator, controller)
    model, scratch = free_model(planning_model(actuator, controller), controller), scratch_for(smap)
    static_pose(smap.statics, u[0], u[1], scratch)
    pose(model.model, scratch.theta, model.state.q)
    model.dead_time[:] = model.u_hat[:] = u
    model.level_hat[:] = np.abs(u)
    return model
