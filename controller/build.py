"""From parameters to the arrays of a rod model: tables given for 10 rods become a model of any number of rods."""

import math

import numpy as np

from controller.kernels.rod import Array, RodModel, make_load, make_work, straight
from controller.kernels.statics import places
from controller.kernels.twin import Camera, Chambers, Creep, Twin
from controller.parameters import BACKBONE_POINTS, SENSORS, Actuator, RigParameters, TwinParameters

TABLE_RODS = 10
"""The paper's stiffness and damping are given for 10 rods (table "Model Parameters")."""

NO_STIFFNESS = 1e-9
"""Stands for a stiffness or damping of zero, whose compliance is infinite [N m/rad]."""

TWIN_BETA = 1.5e-4
"""Stiffness-proportional damping of the twin: small, so that fine rods stay cheap [s]."""

STEP_MARGIN = 0.7
"""A step is at most this share of the largest stable one."""


def build_rod(actuator: Actuator, rods: int, *, omega_B: float = 100.0, zeta_B: float = 1.0) -> RodModel:
    """Chain of `rods` equal rods with the static map that the 10-rod table of `actuator` has.

    The mass is spread evenly, for P2 too: the paper gives walls from 3 to 1.1 mm but not how the mass follows them.
    """
    L = np.full(rods, actuator.length / rods)
    m = np.full(rods, actuator.mass / rods)
    I = m * L**2 / 12  # noqa: E741
    k = joint_profile(actuator.k, rods)
    T_theta = torque_map(actuator.torque_map, rods)
    return RodModel(
        m=m,
        I=I,
        L=L,
        k=k,
        b=joint_profile(actuator.b, rods),
        alpha=actuator.alpha,
        g=np.array(actuator.gravity),
        omega_B=omega_B,
        zeta_B=zeta_B,
        T_theta=T_theta,
        compliance=static_compliance(k, T_theta),
        m_inv=1 / m,
        I_inv=1 / I,
    )


def build_twin(parameters: RigParameters) -> Twin:
    """The simulated plant of `parameters`, at rest, with the substeps that its fastest mode needs."""
    twin, actuator, dt = parameters.twin, parameters.actuator, parameters.controller.dt
    model = twin_model(actuator, twin)
    creeping = model._replace(k=model.k * (1.0 + sum(twin.creep)))
    rods, length = twin.rods, actuator.length
    period, latency = max(1, round(twin.marker_period / dt)), round(twin.marker_latency / dt)
    waiting = latency // period + 1
    return Twin(
        model=model,
        state=straight(model),
        load=make_load(rods),
        work=make_work(rods),
        dt=dt,
        substeps=max(twin.substeps, stable_substeps(creeping, dt, actuator.u_max)),
        friction=twin.friction,
        creep=Creep(np.array(twin.creep), np.array(twin.creep_time), np.zeros((2, rods))),
        chambers=Chambers(
            pressure=np.zeros(4),
            line=np.zeros((round(twin.dead_time / dt) + 1, 4)),
            inflate_time=twin.inflate_time,
            exhaust_time=twin.exhaust_time,
            torque_per_pascal=twin.kappa * twin.torque_gain * actuator.u_max / actuator.pressure_max,
        ),
        camera=Camera(
            markers=places(model.L, length * np.arange(1, SENSORS + 1) / SENSORS),
            noise=twin.marker_noise,
            period=period,
            latency=latency,
            t_ns=np.zeros(waiting, np.int64),
            points=np.zeros((waiting, SENSORS, 2)),
        ),
        backbone=places(model.L, length * np.arange(BACKBONE_POINTS) / (BACKBONE_POINTS - 1)),
        ticks=np.zeros(1, np.int64),
        seed=np.array([twin.seed], np.uint64),
    )


def twin_model(actuator: Actuator, twin: TwinParameters) -> RodModel:
    """The twin's chain: stiffness and gravity times kappa, damping given by zeta of its first mode and TWIN_BETA.

    Its `compliance` maps torques in the model's units, before kappa and the torque gain.
    """
    model = build_rod(actuator, twin.rods)
    k = model.k * twin.kappa * twin.stiffness_scale
    loose = model._replace(k=k, b=np.zeros(twin.rods), alpha=0.0, g=model.g * twin.kappa)
    omega = float(np.abs(natural_modes(loose, np.zeros(twin.rods))).min())
    return loose._replace(b=TWIN_BETA * k, alpha=max(0.0, 2.0 * twin.zeta * omega - TWIN_BETA * omega**2))


def joint_profile(ends: tuple[float, float], rods: int) -> Array:
    """Stiffness or damping of the `rods` joints, from the table's values at its first and last joint.

    A joint carries the compliance of the backbone between the middles of the rods it joins. In the table the base joint
    counts a whole cell, so the backbone begins half a cell before the clamp; behind the last middle nothing bends.
    Compliance per length is constant within a cell of the table.
    """
    cells = 1.0 / np.maximum(np.linspace(*ends, TABLE_RODS), NO_STIFFNESS)
    total = np.concatenate([[0.0], np.cumsum([*cells, cells[-1]])])
    edges = np.concatenate([[-0.5 / TABLE_RODS], (np.arange(rods) + 0.5) / rods])
    return np.asarray(1.0 / np.diff(np.interp(edges * TABLE_RODS + 0.5, np.arange(TABLE_RODS + 2), total)))


def torque_map(name: str, rods: int) -> Array:
    """T_theta (N,2): net torque on each rod per u1, u2 (paper, "Parameter Estimation"; presets in PHYSICS.md).

    At 10 rods the chambers end at rods 5 and 10. For another N the torque is shared by the two rods whose middles
    enclose the middle of that rod of 10: on the nearest rod alone, the angle behind it would be wrong by up to 10 %.
    """
    middle, tip = spread_torque(TABLE_RODS // 2, rods), spread_torque(TABLE_RODS, rods)
    first = middle - spread_torque(1, rods) if name == "base_mid_tip" else middle
    return np.column_stack([first, tip - middle])


def spread_torque(table_rod: int, rods: int) -> Array:
    """Unit torque (N,) at the middle of rod `table_rod` of 10, as shares on the rods of a chain of `rods`."""
    at = np.clip((table_rod - 0.5) / TABLE_RODS * rods - 0.5, 0.0, rods - 1.0)
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(np.arange(rods) - at)))


def static_compliance(k: Array, T_theta: Array) -> Array:
    """K_theta^-1 T_theta (N,2): torques summed from the tip, divided by the joints' stiffness, summed from the base."""
    joint_torque = np.cumsum(T_theta[::-1], axis=0)[::-1]
    return np.asarray(np.cumsum(joint_torque / k[:, None], axis=0))


def natural_modes(model: RodModel, theta: Array, K_o: float = 0.0) -> Array:
    """Eigenvalues (2N,) [1/s] of the chain's small motions about the pose theta (N,), held by K_o [N/m] at its end.

    In angles alone: the constraints fix x and y. Eigenvalues are complex; Baumgarte's are not among them.
    """
    J_x, J_y = centre_jacobian(model.L, theta)
    M = J_x.T * model.m @ J_x + J_y.T * model.m @ J_y + np.diag(model.I)
    hinge = np.eye(model.L.size) - np.eye(model.L.size, k=-1)
    K = hinge.T * model.k @ hinge + K_o * (np.outer(J_x[-1], J_x[-1]) + np.outer(J_y[-1], J_y[-1]))
    B = hinge.T * model.b @ hinge + model.alpha * M
    zero, one = np.zeros_like(M), np.eye(model.L.size)
    return np.linalg.eigvals(np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, B)]]))


def centre_jacobian(L: Array, theta: Array) -> tuple[Array, Array]:
    """Derivatives of the rods' centres by the angles: rows rods, columns angles (N,N) [m/rad], for x and for y."""
    arm = np.tril(np.tile(L, (L.size, 1))) - np.diag(L) / 2
    return -arm * np.sin(theta), arm * np.cos(theta)


def largest_step(model: RodModel, u_max: float = 0.0, K_o: float = 0.0) -> float:
    """Largest step [s] for which RK4 damps every mode, straight and in static poses with torques up to u_max [N m]."""
    poses = [model.compliance @ (u_max * np.array(u)) for u in ((0, 0), (1, 0), (0, 1), (1, -1), (0.5, 0.5))]
    modes = np.concatenate([natural_modes(model, pose, K_o) for pose in poses])
    drift = np.roots([1.0, 2.0 * model.zeta_B * model.omega_B, model.omega_B**2])
    modes = np.concatenate([modes, drift])
    low, high = 0.0, 3.0 / float(np.abs(modes).max())
    for _ in range(40):
        step = (low + high) / 2
        z = step * modes
        growth = np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))
        low, high = (step, high) if growth.max() <= 1.0 else (low, step)
    return low


def stable_substeps(model: RodModel, dt: float, u_max: float = 0.0, K_o: float = 0.0) -> int:
    """Steps that dt [s] must be cut into, with a margin, for RK4 to be stable (see `largest_step`)."""
    return math.ceil(dt / (STEP_MARGIN * largest_step(model, u_max, K_o)))
