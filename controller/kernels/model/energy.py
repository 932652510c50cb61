"""The energy ledger of the rod model: what it holds against what it was given (Eq. HDOT).

Paper, "Stability and Passivity Analysis". Its proof leaves Baumgarte's term out and lets the observer's force act on
p_N, as it does here, too (`springs.py`). Here Baumgarte's power is counted, so the ledger closes to the integrator's
order.
"""

import numpy as np

from controller.arrays import Array
from controller.kernels.compiled import inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.rod import Load, RodModel, RodState, Work
from controller.kernels.model.springs import spring_power

DAMPING, PNEUMATIC, OBSERVER, BAUMGARTE = range(4)


class Ledger(Group):
    """Running account of the stored energy."""

    energy: Array
    """(1,) H after the last step [J]."""
    given: Array
    """(1,) H at the opening plus the work of the four powers since then [J]."""
    power: Array
    """(4,) mean of the four powers over the last step [W]: damping, pneumatic, observer, Baumgarte."""


def make_ledger() -> Ledger:
    """A ledger to be opened by `open_ledger`; it fits a chain at rest, straight and without gravity."""
    return Ledger(np.zeros(1), np.zeros(1), np.zeros(4))


@inlined
def stored_energy(model: RodModel, q: Array, v: Array) -> float:
    """H = 1/2 q'^T M q' + 1/2 q^T K q - gravity's work from the origin [J]; K acts on the bend beyond that of rest.

    Paper, "Stability and Passivity Analysis"; gravity and rest bend are not in the paper.
    """
    H = theta_before = 0.0
    for i in range(model.m.size):
        bend = q[2, i] - theta_before
        theta_before = q[2, i]
        H += 0.5 * model.m[i] * (v[0, i] * v[0, i] + v[1, i] * v[1, i]) + 0.5 * model.I[i] * v[2, i] * v[2, i]
        stretch = bend - model.bend[i]
        H += 0.5 * model.k[i] * stretch * stretch - model.m[i] * (model.g[0] * q[0, i] + model.g[1] * q[1, i])
    return H


@inlined
def damping_power(model: RodModel, v: Array) -> float:
    """-q'^T B q' [W]: the hinges' dampers and mass-proportional damping, first term of Eq. HDOT."""
    P = omega_before = 0.0
    for i in range(model.m.size):
        rate = v[2, i] - omega_before
        omega_before = v[2, i]
        twice_kinetic = model.m[i] * (v[0, i] * v[0, i] + v[1, i] * v[1, i]) + model.I[i] * v[2, i] * v[2, i]
        P -= model.b[i] * rate * rate + model.alpha * twice_kinetic
    return P


@inlined
def pneumatic_power(model: RodModel, u: Array, v: Array) -> float:
    """(T^T q')^T u [W] of the torques u (2,) [N m], second term of Eq. HDOT."""
    P = 0.0
    for i in range(model.m.size):
        P += v[2, i] * (model.T_theta[i, 0] * u[0] + model.T_theta[i, 1] * u[1])
    return P


@inlined
def load_power(load: Load, v: Array) -> float:
    """Power of the held load [W]: the second term of Eq. HDOT, and of forces that the paper has not."""
    P = 0.0
    for i in range(load.Q_theta.size):
        P += load.F[0, i] * v[0, i] + load.F[1, i] * v[1, i] + load.Q_theta[i] * v[2, i]
    return P


@inlined
def baumgarte_power(a: Array, lam: Array, v: Array) -> float:
    """lambda^T A q' [W]: zero if the hinges held exactly, as the paper takes it, "Stability and Passivity Analysis"."""
    P = distal_x = distal_y = 0.0
    for i in range(a.shape[1]):
        swing_x, swing_y = a[0, i] * v[2, i], a[1, i] * v[2, i]
        P += lam[0, i] * (v[0, i] - swing_x - distal_x) + lam[1, i] * (v[1, i] - swing_y - distal_y)
        distal_x, distal_y = v[0, i] + swing_x, v[1, i] + swing_y
    return P


@kernel
def open_ledger(model: RodModel, state: RodState, out_ledger: Ledger) -> None:
    """Start the account with what `state` holds now: at the start and after every jump of the state.

    H(0): paper, "Stability and Passivity Analysis".
    """
    out_ledger.energy[0] = out_ledger.given[0] = stored_energy(model, state.q, state.v)
    out_ledger.power[:] = 0.0


@kernel
def ledger_step(model: RodModel, state: RodState, load: Load, u: Array, dt: float, work: Work, ledger: Ledger) -> float:
    """Book the `rk4_step` of dt [s] just made, whose stages are in `work`; returns H - given [J], the ledger's error.

    The powers are integrated by the step's own rule (weights 1 2 2 1), so the error is of the integrator's order.
    `u` (2,) [N m] is the part of the load that is pneumatic; the rest of it is the observer's. Eq. HDOT, over one step.
    In place: ledger.
    """
    ledger.power[:] = 0.0
    for stage in range(4):
        weight = 1.0 / 6.0 if stage == 0 or stage == 3 else 1.0 / 3.0
        v = work.v[stage]
        pneumatic = pneumatic_power(model, u, v)
        ledger.power[DAMPING] += weight * damping_power(model, v)
        ledger.power[PNEUMATIC] += weight * pneumatic
        pulled = spring_power(load.springs, model.arm, work.q[stage], v, work.a[stage])
        ledger.power[OBSERVER] += weight * (pulled + load_power(load, v) - pneumatic)
        ledger.power[BAUMGARTE] += weight * baumgarte_power(work.a[stage], work.lam[stage], v)
    ledger.energy[0] = stored_energy(model, state.q, state.v)
    for power in ledger.power:
        ledger.given[0] += dt * power  # Eq. HDOT
    return ledger.energy[0] - ledger.given[0]
