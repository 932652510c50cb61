"""The chain's small motions, and the largest step for which they stay small."""

import math
from collections.abc import Callable

import numpy as np

from controller.arrays import Array
from controller.assembly.equilibrium import gravity_torque
from controller.errors import ParameterError
from controller.kernels.model.rod import RodModel, RodState
from controller.kernels.model.statics import Places, places, pose
from controller.schema.parameters import BACKBONE_POINTS, OBSERVER_DAMPING_MAX, OBSERVER_GAIN_MAX, SENSORS

DENSE_MAX = 60
"""Most rods for which every mode is computed."""
ROUNDS = 1000
"""Most restarts of the search for a fastest motion: a second for 1000 rods."""
HALF_DISC = 2.615
"""RK4 is stable for every mode that does not grow with dt |s| up to this."""
SUBSTEPS_MAX = 100
"""Steps of a plant in a period: with 14 rods they take some 0.15 ms."""
STEP_MARGIN = 0.7
"""A step is at most this share of the largest stable one."""


def natural_modes(model: RodModel, theta: Array, K_o: float = 0.0, B_o: float = 0.0) -> Array:
    """Eigenvalues (2N,) [1/s] of `small_motions`, complex; Baumgarte's are not among them."""
    return np.asarray(np.linalg.eigvals(small_motions(model, theta, K_o, B_o)))


def undamped(model: RodModel) -> Array:
    """Undamped angular frequencies [rad/s] of all modes about its rest (N,), the lowest first."""
    loose = model._replace(b=np.zeros_like(model.b), alpha=0.0)
    return np.sort(np.abs(natural_modes(loose, model.rest)))[::2]


def slowest(model: RodModel) -> tuple[float, float]:
    """Undamped frequency [rad/s] and damping ratio of the slowest motion about its rest."""
    modes = natural_modes(model, model.rest)
    s = modes[np.argmin(np.abs(modes))]
    return float(abs(s)), float(-s.real / abs(s))


def small_motions(model: RodModel, theta: Array, K_o: float = 0.0, B_o: float = 0.0) -> Array:
    """The chain's small motions about the pose theta (N,): rates (2N,2N) of angles off it, then of their rates.

    It is held by K_o [N/m] and B_o [N s/m] at all sensors: no set of fewer makes it faster. In angles alone: the
    constraints fix x and y.
    """
    J_x, J_y = centre_jacobian(model, theta)
    M = J_x.T * model.m @ J_x + J_y.T * model.m @ J_y + np.diag(model.I)
    hinge = np.eye(model.L.size) - np.eye(model.L.size, k=-1)
    P = point_slopes(model, theta, sensor_places(model))
    K = hinge.T * model.k @ hinge + K_o * P.T @ P - np.diag(gravity_torque(model, theta)[1])
    B = hinge.T * model.b @ hinge + B_o * P.T @ P + model.alpha * M
    zero, one = np.zeros_like(M), np.eye(model.L.size)
    return np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, B)]])


def move(model: RodModel, theta: Array, x: Array, state: RodState) -> None:
    """Set `state` off the pose theta (N,) by x (2N,), angles [rad] before rates [rad/s]; hinges stay closed."""
    angles, rates = theta + x[: theta.size], x[theta.size :]
    pose(model, angles, state.q)
    turn = rates * np.array([-np.sin(angles), np.cos(angles)])
    state.v[:2], state.v[2] = np.cumsum(model.L * turn, axis=1) - (model.L - model.arm) * turn, rates


def sensor_places(model: RodModel) -> Places:
    """The material points of the sensors (SENSORS)."""
    return places(model, float(model.L.sum()) * np.arange(1, SENSORS + 1) / SENSORS)


def backbone_places(model: RodModel) -> Places:
    """The telemetry's points along the backbone (BACKBONE_POINTS), from clamp to tip."""
    return places(model, float(model.L.sum()) * np.arange(BACKBONE_POINTS) / (BACKBONE_POINTS - 1))


def point_slopes(model: RodModel, theta: Array, at: Places) -> Array:
    """Derivatives (2 s,N) [m/rad] of the points, x then y of each, by the angles."""
    rods = np.arange(theta.size)
    reach = np.where(rods < at.rod[:, None], model.L, 0.0)
    reach[np.arange(at.rod.size), at.rod] = model.arm[at.rod] + at.offset
    return np.stack([-reach * np.sin(theta), reach * np.cos(theta)], axis=1).reshape(-1, theta.size)


def centre_jacobian(model: RodModel, theta: Array) -> tuple[Array, Array]:
    """Derivatives of the rods' centres by the angles: rows rods, columns angles (N,N) [m/rad], for x and for y."""
    reach = np.tril(np.tile(model.L, (model.L.size, 1)), -1) + np.diag(model.arm)
    return -reach * np.sin(theta), reach * np.cos(theta)


def largest_step(model: RodModel, u_max: float = 0.0, K_o: float = 0.0, B_o: float = 0.0) -> float:
    """Largest step [s] for which RK4 damps every mode, at rest and in static poses with torques up to u_max [N m].

    K_o and B_o as in `natural_modes`. A mode that grows by itself, as a body does that gravity topples, may grow by as
    much in a step. For more rods than DENSE_MAX this is a lower bound, at most 7 % low: all modes within the half disc
    in which RK4 is stable.
    """
    torques = u_max * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, -1.0), (0.5, 0.5)])
    poses = model.rest + torques @ model.compliance.T
    drift = np.roots([1.0, 2.0 * model.zeta_B * model.omega_B, model.omega_B**2])
    if model.L.size > DENSE_MAX:
        return HALF_DISC / max(float(np.abs(drift).max()), *(fastest_mode(model, pose, K_o, B_o) for pose in poses))
    modes = np.concatenate([drift, *(natural_modes(model, pose, K_o, B_o) for pose in poses)])
    low, high = 0.0, 3.0 / float(np.abs(modes).max())
    for _ in range(40):
        step = (low + high) / 2
        z = step * modes
        growth = np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))
        low, high = (step, high) if (growth <= np.maximum(1.0, np.abs(np.exp(z)))).all() else (low, step)
    return low


def fastest_mode(model: RodModel, theta: Array, K_o: float = 0.0, B_o: float = 0.0) -> float:
    """Bound on |s| [1/s] over the `natural_modes`, in O(N): s^2 + beta s + omega^2 = 0 with the most of each."""
    accelerate, P = angular_acceleration(model, theta), point_slopes(model, theta, sensor_places(model))
    topple = np.maximum(0.0, -gravity_torque(model, theta)[1])

    def stiffness(x: Array) -> Array:
        return np.asarray(hinge_torque(model.k, x) + topple * x + K_o * (P.T @ (P @ x)))

    def damping(x: Array) -> Array:
        return np.asarray(hinge_torque(model.b, x) + B_o * (P.T @ (P @ x)))

    omega_2 = strongest(lambda x: accelerate(stiffness(x)), model.L.size)
    beta = strongest(lambda x: accelerate(damping(x)), model.L.size) + model.alpha
    return max(math.sqrt(omega_2), beta / 2 + math.sqrt(max(0.0, beta**2 / 4 - omega_2)))


def hinge_torque(c: Array, x: Array) -> Array:
    """Torques (N,) that springs or dampers c (N,) in the hinges have against angles or rates x (N,)."""
    hinge = c * np.diff(x, prepend=0.0)
    return np.asarray(hinge - np.append(hinge[1:], 0.0))


def angular_acceleration(model: RodModel, theta: Array) -> Callable[[Array], Array]:
    """The map from torques on the angles (N,) to theta'' (N,) of the chain at rest in the pose theta, in O(N).

    By the hinge forces, as in the rod kernel: A M^-1 A^T, here in LAPACK's band storage (two rows a hinge).
    """
    from scipy.linalg import cho_solve_banded, cholesky_banded  # not for a start of the server

    a = model.arm * np.array([-np.sin(theta), np.cos(theta)])
    rods, swing = theta.size, a * a[:, None] * model.I_inv
    light = np.eye(2)[:, :, None] * model.m_inv
    D = (swing + light) + np.concatenate([np.zeros((2, 2, 1)), (swing + light)[:, :, :-1]], axis=2)
    E = np.concatenate([np.zeros((2, 2, 1)), (swing - light)[:, :, :-1]], axis=2)
    band = np.zeros((4, rods, 2))
    band[3] = D[[0, 1], [0, 1]].T
    band[2, :, 1], band[2, :, 0] = D[0, 1], E[1, 0]
    band[1, :, 0], band[1, :, 1] = E[0, 0], E[1, 1]
    band[0, :, 1] = E[0, 1]
    factor = cholesky_banded(band.reshape(4, 2 * rods))

    def accelerate(torque: Array) -> Array:
        ends = a * (model.I_inv * torque)
        ends[:, 1:] += a[:, :-1] * (model.I_inv * torque)[:-1]
        pull = cho_solve_banded((factor, False), ends.T.ravel()).reshape(rods, 2).T
        pull[:, :-1] += pull[:, 1:].copy()
        return np.asarray(model.I_inv * (torque - (a * pull).sum(axis=0)))

    return accelerate


def strongest(apply: Callable[[Array], Array], size: int) -> float:
    """Largest eigenvalue of the map `apply` of vectors (size,), to 0.1 %; 0 for a map to zero."""
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigs  # as above

    start = np.random.default_rng(0).normal(size=size)
    if not apply(start).any():
        return 0.0
    operator = LinearOperator((size, size), apply, dtype=float)
    try:
        found = eigs(operator, 1, tol=1e-3, v0=start, maxiter=ROUNDS, return_eigenvectors=False)
    except ArpackError as error:
        raise ParameterError(f"rods = {size}: their fastest motion was not found in {ROUNDS} rounds") from error
    return float(found[0].real)


def largest_gains(model: RodModel, dt: float, u_max: float) -> tuple[float, float]:
    """The most K_o [N/m], and with it B_o [N s/m], with which RK4 with dt [s] is stable, whatever is sensed.

    As far as settings allow, at rest and bent by u_max [N m]. Raises ParameterError if it is not stable without any.
    """
    bound = largest_step(model, u_max)
    if dt > bound:
        raise ParameterError(
            f"dt = {dt} s is too long for RK4 with this actuator and rods = {model.L.size}: the largest stable dt is "
            f"{bound:.3g} s; integrator = implicit is stable with any dt; k, b, mass, length and observer_kappa decide"
        )
    K_most = _most(lambda K_o: largest_step(model, u_max, K_o) >= dt, OBSERVER_GAIN_MAX)

    def stable(B_o: float) -> bool:  # a spring slows down what is more than critically damped
        return all(largest_step(model, u_max, K_o, B_o) >= dt for K_o in (0.0, K_most))

    return K_most, _most(stable, OBSERVER_DAMPING_MAX)


def _most(stable: Callable[[float], bool], most: float) -> float:
    """The largest gain up to `most`, in hundredths, of which `stable` holds, as it does of 0."""
    if stable(most):
        return most
    low, high = 0.0, most
    while high - low > 1e-3 * most:
        middle = (low + high) / 2
        low, high = (middle, high) if stable(middle) else (low, middle)
    return math.floor(100.0 * low) / 100.0


def stable_substeps(model: RodModel, dt: float, u_max: float = 0.0) -> int:
    """Steps that dt [s] must be cut into, with a margin, for RK4 to be stable (see `largest_step`).

    Raises ParameterError where they are more than can be computed in time.
    """
    step = STEP_MARGIN * largest_step(model, u_max)
    if step * SUBSTEPS_MAX < dt:
        raise ParameterError(
            f"k, mass and length: the plant's fastest motion needs steps of {step:.3g} s, and {SUBSTEPS_MAX} in "
            f"dt = {dt} s are the most; twin.integrator = 1, the implicit step, takes any"
        )
    return math.ceil(dt / step)
