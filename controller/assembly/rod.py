"""From an actuator to the arrays of a rod model: a table of a few rods becomes a model of any number of rods."""

import math
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from controller.arrays import Array
from controller.assembly.equilibrium import ChainStatics, equilibrium
from controller.assembly.stability import slowest
from controller.errors import ParameterError
from controller.kernels.model.rod import RodModel
from controller.schema.actuator import Actuator
from controller.schema.rigidity import joint_stiffness

RODS_MIN, RODS_MAX = 2, 1000
"""Rods of a model."""

STIFFNESS_DAMPING = 1.5e-4
"""Stiffness-proportional damping where a damping ratio is asked for: small, so that fine rods stay cheap [s]."""

NO_STIFFNESS = 1e-9
"""Stands for a stiffness or damping of zero, whose compliance is infinite [N m/rad]."""


@contextmanager
def computable(actuator: Actuator) -> Iterator[None]:
    """Numbers that run over, and matrices that are singular to the digits there are, become a ParameterError."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except ParameterError:
        raise
    except (ArithmeticError, ValueError, np.linalg.LinAlgError, MemoryError) as error:
        raise ParameterError(
            f"actuator {actuator.name}: k, b, mass, length, rest_curvature and gravity do not fit together: {error}"
        ) from error


def build_rod(actuator: Actuator, rods: int, *, omega_B: float = 100.0, zeta_B: float = 1.0) -> RodModel:
    """Chain of `rods` equal rods with the static map that the table of `actuator` has.

    Raises ParameterError for a number of rods out of bounds, and where gravity makes the unactuated body buckle.
    """
    if not RODS_MIN <= rods <= RODS_MAX:
        raise ParameterError(f"rods = {rods} is outside [{RODS_MIN}, {RODS_MAX}]")
    L = np.full(rods, actuator.length / rods)
    m, arm, I = masses(actuator, L)  # noqa: E741
    k, b = joints(actuator, rods)
    T_theta = torque_map(actuator, rods)
    bend = rest_bend(actuator, rods)
    rest, compliance = equilibrium(ChainStatics(L, arm, m, k, bend, np.array(actuator.gravity)), T_theta)
    return RodModel(
        m=m,
        I=I,
        L=L,
        arm=arm,
        k=k,
        b=b,
        bend=bend,
        alpha=actuator.alpha,
        g=np.array(actuator.gravity),
        omega_B=omega_B,
        zeta_B=zeta_B,
        T_theta=T_theta,
        rest=rest,
        compliance=compliance,
        stiffening=stiffening(actuator, T_theta),
        stretching=stretching(actuator, rods),
        m_inv=1 / m,
        I_inv=1 / I,
    )


def hastened(model: RodModel, kappa: float) -> RodModel:
    """`model` with its inertia over `kappa`: the same statics and damping ratios, motions kappa^(1/2) times as fast."""
    m, I, pace = model.m / kappa, model.I / kappa, math.sqrt(kappa)  # noqa: E741
    return model._replace(
        m=m, I=I, m_inv=1 / m, I_inv=1 / I, g=model.g * kappa, b=model.b / pace, alpha=model.alpha * pace
    )


def damped(model: RodModel, zeta: float) -> RodModel:
    """`model`, the damping ratio of whose first mode about its rest is `zeta`; its other modes have hardly more."""
    loose = model._replace(b=np.zeros_like(model.b), alpha=0.0)
    omega = slowest(loose)[0]
    alpha = max(0.0, 2.0 * zeta * omega - STIFFNESS_DAMPING * omega**2)
    return loose._replace(b=STIFFNESS_DAMPING * model.k, alpha=alpha)


def joints(actuator: Actuator, rods: int) -> tuple[Array, Array]:
    """Stiffness [N m/rad] and damping [N m s/rad] (rods,) of the joints: from EI where it is given, else the table."""
    if actuator.EI is None:
        table = actuator.table_rods
        return joint_profile(profile(actuator.k, table), rods), joint_profile(profile(actuator.b, table), rods)
    k = joint_stiffness(actuator.EI, actuator.EI_arc, actuator.length, rods)
    return k, np.asarray((actuator.beta or 0.0) * k)


def profile(values: tuple[float, ...], count: int) -> Array:
    """`values` as `count` numbers from base to tip: one is uniform, two are the ends of a line."""
    return np.interp(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, len(values)), values)


def masses(actuator: Actuator, L: Array) -> tuple[Array, Array, Array]:
    """Mass (N,) [kg], arm (N,) [m] and moment of inertia (N,) [kg m^2] of uniform rods, the tip load on the last."""
    cells = profile(actuator.mass_profile, actuator.table_rods)
    share = np.diff(spread(cells, np.linspace(0.0, 1.0, L.size + 1)))
    m, arm = actuator.mass * share / share.sum(), L / 2
    I = m * L**2 / 12  # noqa: E741
    body, load = m[-1], actuator.tip_load
    m[-1] = body + load
    arm[-1] = (body / 2 + load) * L[-1] / m[-1]
    I[-1] += body * load / m[-1] * (L[-1] / 2) ** 2
    return m, arm, I


def spread(cells: Array, at: Array) -> Array:
    """Integral from 0 to `at` (n,), shares of the length, of what is constant in each of equal `cells` (c,)."""
    total = np.concatenate([[0.0], np.cumsum(cells)]) / cells.size
    return np.asarray(np.interp(at, np.linspace(0.0, 1.0, cells.size + 1), total))


def joint_profile(cells: Array, rods: int) -> Array:
    """Stiffness or damping of the `rods` joints, from the table's values at its joints (c,).

    A joint carries the compliance of the backbone between the middles of the rods it joins. In the table the base joint
    counts a whole cell, so the backbone begins half a cell before the clamp; behind the last middle nothing bends.
    Compliance per length is constant within a cell of the table.
    """
    table = cells.size
    compliance = 1.0 / np.maximum(cells, NO_STIFFNESS)
    total = np.concatenate([[0.0], np.cumsum([*compliance, compliance[-1]])])
    edges = np.concatenate([[-0.5 / table], (np.arange(rods) + 0.5) / rods])
    return np.asarray(1.0 / np.diff(np.interp(edges * table + 0.5, np.arange(table + 2), total)))


def rest_bend(actuator: Actuator, rods: int) -> Array:
    """Bend of each joint at rest (N,) [rad]: the rest curvature between the middles of the rods it joins."""
    curvature = profile(actuator.rest_curvature, actuator.table_rods)
    return actuator.length * np.diff(spread(curvature, bend_edges(rods)))


def bend_edges(n: int) -> Array:
    """Ends (n+1,) of the cells about the bends of n rods, as shares of the length: the clamp, then their middles."""
    return np.concatenate([[0.0], (np.arange(n) + 0.5) / n])


def torque_map(actuator: Actuator, rods: int) -> Array:
    """T_theta (N,2): net torque on each rod per u1, u2 (paper, "Parameter Estimation").

    For another number of rods than the table's, a torque is shared by the two rods whose middles enclose the middle of
    that rod of the table: on the nearest rod alone, the angle behind it would be wrong by up to 10 %.
    """
    table, length = actuator.table_rods, actuator.length
    if actuator.chamber_arcs is not None:
        ends = [[shared_torque(s / length, rods) for s in pair] for pair in actuator.chamber_arcs]
    else:
        ends = [[spread_torque(rod, table, rods) for rod in pair] for pair in actuator.chambers]
    return np.column_stack([end - start for start, end in ends])


def stiffening(actuator: Actuator, T_theta: Array) -> Array:
    """Share of the hinges' stiffness that |u1| and |u2| add (N,2) [1/(N m)], by their pressures; (0,2) for none.

    A hinge is stiffened by as much of a pair's pressure as it has of the pair's torque.
    """
    if not any(actuator.stiffening):
        return np.zeros((0, 2))
    reached = np.cumsum(T_theta[::-1], axis=0)[::-1]
    return np.asarray(np.array(actuator.stiffening) * actuator.pair_slopes * reached)


def stretching(actuator: Actuator, rods: int) -> Array:
    """Share of the rods' lengths that |u1| and |u2| add (N,2) [1/(N m)], by their pressures; (0,2) for none."""
    if not any(actuator.stretching):
        return np.zeros((0, 2))
    reached = [covered(np.linspace(0.0, 1.0, rods + 1), *pair) for pair in chamber_ends(actuator)]
    return np.asarray(np.array(actuator.stretching) * actuator.pair_slopes * np.column_stack(reached))


def chamber_ends(actuator: Actuator) -> Array:
    """Where each pair begins and ends (2,2), as shares of the length: by the table at the ends of two of its rods."""
    if actuator.chamber_arcs is not None:
        return np.array(actuator.chamber_arcs) / actuator.length
    return np.array(actuator.chambers) / actuator.table_rods


def covered(edges: Array, first: float, last: float) -> Array:
    """Share (n,) of each cell between `edges` (n+1,) that lies between `first` and `last`."""
    return np.asarray(np.diff(np.clip(edges, first, last)) / np.diff(edges))


def stiffest(model: RodModel, u_max: float) -> Array:
    """Stiffness (N,) [N m/rad] of the hinges under both torques of u_max [N m]."""
    return np.asarray(model.k * (1.0 + u_max * model.stiffening.sum(axis=1)) if model.stiffening.size else model.k)


def spread_torque(rod: int, table: int, rods: int) -> Array:
    """Unit torque (N,) at the middle of `rod` of `table` rods, as shares on a chain of `rods`; rod 0 is the clamp."""
    return np.zeros(rods) if rod == 0 else shared_torque((rod - 0.5) / table, rods)


def shared_torque(share: float, rods: int) -> Array:
    """Unit torque (N,) at this share of the length, on the two rods whose middles enclose it, or on one and the clamp.

    The joint between them then carries as much of it as reaches into the joint's part of the backbone.
    """
    at = np.clip(share * rods - 0.5, -0.5, rods - 1.0)
    weights = np.maximum(0.0, 1.0 - np.abs(np.arange(rods) - at))
    weights[0] = 1.0 + 2.0 * at if at < 0.0 else weights[0]
    return np.asarray(weights)
