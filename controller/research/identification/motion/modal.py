"""The first mode of small motion, and the model of a body that has it: what a modal fit varies, and what it keeps."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import minimize_scalar

from controller.arrays import Array
from controller.assembly.equilibrium import gravity_torque
from controller.assembly.rod import build_rod
from controller.assembly.stability import centre_jacobian, point_slopes
from controller.errors import DataError
from controller.kernels.model.rod import RodModel
from controller.kernels.model.statics import places
from controller.research.identification.motion.damping import log_decrement
from controller.research.identification.motion.directions import SURE, across_body, direction_law, law_scatter
from controller.research.identification.offline import in_plane
from controller.research.identification.plane import PlaneMotion
from controller.research.identification.poses import fine
from controller.schema.actuator import Actuator, Tracking


def rest_matrices(model: RodModel) -> tuple[Array, Array, Array]:
    """Inertia [kg m^2], the hinges' stiffness and gravity's [N m/rad] (N,N each) at rest."""
    J_x, J_y = centre_jacobian(model, model.rest)
    M = J_x.T * model.m @ J_x + J_y.T * model.m @ J_y + np.diag(model.I)
    hinge = np.eye(model.L.size) - np.eye(model.L.size, k=-1)
    return M, hinge.T * model.k @ hinge, -np.diag(gravity_torque(model, model.rest)[1])


LATE = 0.3
"""Release and higher modes are over by then [s]."""
UNSURE = 1e-2
"""Standard error of a ratio from one decay alone, which shows no spread."""
STEEPEST = 5.0
"""Tapers are looked for up to k tip / k base = exp(5) or exp(-5)."""
SMALL = 0.03
"""A motion of the last body below this share of its arc length is small."""

TRACKING_RATE = 120.0
"""Rate at which the offline observer's springs draw the last body to its samples, critically damped [rad/s]: faster
than the modes that a trunk shows, slow enough to smooth marker noise. Of 60, 120, 240 and 480 chosen by the trunk's
identification decays, each left out once (docs/identification.md)."""


class FirstMode(NamedTuple):
    """First mode, in each decay that shows it (n,): frequency and damping of small motion."""

    omegas: Array
    """Undamped [rad/s]."""
    zetas: Array
    ratios: Array
    """Lateral motions of the inner bodies over the last one's (d,bodies-1), of all decays."""
    directions: Array
    """Unit vectors of these motions in the file's coordinates (d,dims)."""

    @property
    def omega(self) -> float:
        """Median [rad/s]."""
        return float(np.median(self.omegas))

    @property
    def zeta(self) -> float:
        """Median [1]."""
        return float(np.median(self.zetas))


class Form(NamedTuple):
    """Which stiffness profiles are looked for."""

    geometric: bool = False
    """From base to tip stiffness falls by the same factor from joint to joint, else by the same amount."""
    directional: bool = False
    """One stiffness profile for each of two directions of bending at right angles, else one for all."""


PLAIN = Form()


class Shape(NamedTuple):
    """What the first mode leaves open; logarithms of what must stay positive."""

    taper: float
    """ln(k tip / k base)."""
    load: float
    """ln(tip load / mass); only where the base actuator has no tip load."""
    stiff: float
    """ln(share / (1 - share)) of the first mode's damping that is proportional to stiffness, the rest is to mass."""
    delay: float
    """After which the torques that held the pose begin to fade [s]."""
    fade: float
    """ln of how long they do [s]."""
    hold: float
    """ln of these torques' scatter over (mass + tip load) 9.81 m/s^2 length."""
    slope: float
    """ln of the ratio of the scatter at the outermost and the innermost body, halved."""
    cos2: float = 0.0
    sin2: float = 0.0
    """Tapers for bending along the body's principal directions are taper +- |(cos2, sin2)|, and twice the angle of the
    first direction is that of (cos2, sin2). Only for a directional body."""


def small_mode(motions: Sequence[PlaneMotion], length: float) -> FirstMode:
    """From the last body; DataError when no decay swings to and fro while it is small.

    A real body is slower and more damped in large motions; the linear model is that of small ones.
    """
    found = [mode for one in motions if (mode := _mode_of(one, SMALL * length)) is not None]
    if not found:
        raise DataError(
            f"none of {len(motions)} decays swings to and fro with less than {1e3 * SMALL * length:.1f} mm "
            f"({100 * SMALL:.0f} % of the last body's arc length): no mode can be read"
        )
    omegas, zetas = np.array(found).T
    return FirstMode(omegas, zetas, *mode_ratios(motions))


def _mode_of(motion: PlaneMotion, small: float) -> tuple[float, float] | None:
    s = motion.lateral[:, -1]
    large = np.flatnonzero(np.abs(s) >= small)
    begin = int(large[-1]) + 1 if large.size else 0
    try:
        found = log_decrement([(motion.t[begin:], s[begin:])])
    except DataError:
        return None
    return found.omega, found.zeta.value


def mode_ratios(motions: Sequence[PlaneMotion]) -> tuple[Array, Array]:
    """Lateral motions of the inner bodies over the last one's in each decay (d,bodies-1), from LATE on; directions."""
    moving = [one for one in motions if np.any(one.lateral[one.t >= LATE, -1])]
    late = [one.lateral[one.t >= LATE] for one in moving]
    ratios = np.array([y[:, :-1].T @ y[:, -1] / (y[:, -1] @ y[:, -1]) for y in late])
    return ratios, np.array([one.direction for one in moving])


class IdentifiedBody:
    """A base actuator with what frame and first mode say of it; `shaped` adds the rest.

    Decays in which only gravity and inertia act fix ratios of masses and stiffness, not their scale: the base
    actuator's mass does. Its tip load is taken as known, too, if it has one.
    """

    def __init__(
        self, base: Actuator, frame: Tracking, mode: FirstMode, form: Form = PLAIN, rate: float = TRACKING_RATE
    ) -> None:
        """`base` says masses and gravity, `frame` where the bodies sit, `rate` how fast its observer is [rad/s]."""
        known = {"length": frame.arcs[-1], "rest_curvature": (0.0,), "tracking": None, "alpha": 0.0}
        self._base = base.model_copy(update=known)
        self._frame, self.mode, self.form, self._rate = frame, mode, form, rate
        law = direction_law(mode.directions, np.array(frame.axis), directional=form.directional)
        self._scatter = law_scatter(law, mode.ratios)

    def shaped(self, shape: Shape) -> Actuator:
        """The actuator of this shape. DataError when its mode is slower than a pendulum of this load."""
        mode, body = self.mode, self._elastic(shape)
        share = float(1.0 / (1.0 + np.exp(-shape.stiff)))
        damping = 2.0 * mode.zeta * mode.omega
        beta, alpha = share * damping / elastic_share(body), (1.0 - share) * damping
        b = tuple(beta * k for k in body.k)
        return body.model_copy(update={"b": b, "alpha": alpha, "tracking": _tracking(body, shape, self._rate)})

    def ratios_off(self, shape: Shape) -> Array:
        """Ratios of the shape's first mode in each decay's plane minus the measured ones, in their scatter (d,)."""
        measured, directions = self.mode.ratios, self.mode.directions
        body, count = self._elastic(shape), len(measured)
        if body.tracking is None or body.tracking.k_across is None:
            known = np.tile(first_mode(body, self._frame.arcs), (count, 1))
        else:
            known = np.array([first_mode(in_plane(body, one), self._frame.arcs) for one in directions])
        off = (known - measured) / np.maximum(self._scatter, np.sqrt(count) * SURE if count > 1 else UNSURE)
        return np.asarray(off.ravel())

    def start(self, shape: Shape) -> Shape:
        """`shape` with the taper that suits the measured ratios best."""

        def misfit(taper: float) -> float:
            return float(np.square(self.ratios_off(shape._replace(taper=taper))).sum())

        best = minimize_scalar(misfit, bounds=(-STEEPEST, STEEPEST), method="bounded")
        return shape._replace(taper=float(best.x))

    def _elastic(self, shape: Shape) -> Actuator:
        base = self._base
        if not base.tip_load:
            base = base.model_copy(update={"tip_load": base.mass * float(np.exp(shape.load))})
        apart = math.hypot(shape.cos2, shape.sin2)
        geometric = self.form.geometric
        body = tapered(base, self.mode.omega, shape.taper + apart, geometric=geometric)
        frame = self._frame
        if apart:
            angle = math.atan2(shape.sin2, shape.cos2) / 2
            principal = np.array([math.cos(angle), math.sin(angle)]) @ across_body(np.array(frame.axis))
            other = tapered(base, self.mode.omega, shape.taper - apart, geometric=geometric)
            frame = frame.model_copy(update={"principal": tuple(principal.tolist()), "k_across": other.k})
        return body.model_copy(update={"tracking": frame})


def tapered(base: Actuator, omega: float, taper: float, *, geometric: bool = False) -> Actuator:
    """`base` with ln(k tip / k base) = taper, linear or geometric in between, and a first mode of omega [rad/s]."""
    k = np.exp(np.linspace(-taper / 2, taper / 2, base.table_rods if geometric else 2))
    loose = base.model_copy(update={"k": tuple(k.tolist())})
    k *= stiffness_scale(build_rod(loose, fine(base)), omega)
    return base.model_copy(update={"k": tuple(k.tolist())})


def first_mode(actuator: Actuator, arcs: Sequence[float]) -> Array:
    """Lateral motions of the inner bodies over the last one's (bodies-1,) in the first mode."""
    model = build_rod(actuator, fine(actuator))
    M, K, G = rest_matrices(model)
    _, modes = eigh(K + G, M, subset_by_index=[0, 0])
    y = point_slopes(model, model.rest, places(model, np.array(arcs)))[1::2] @ modes[:, 0]
    return np.asarray(y[:-1] / y[-1])


def elastic_share(actuator: Actuator) -> float:
    """Part of the first mode's omega^2 that is the hinges' [1/s^2]; gravity's part has no damper beside it."""
    M, K, G = rest_matrices(build_rod(actuator, fine(actuator)))
    _, modes = eigh(K + G, M, subset_by_index=[0, 0])
    return float(modes[:, 0] @ K @ modes[:, 0])


def stiffness_scale(model: RodModel, omega: float) -> float:
    """Factor on all joints with which the first mode about the rest has omega [rad/s].

    det(s K + G - omega^2 M) = 0 with gravity's stiffness G: an eigenvalue problem in s, whose largest root belongs to
    the first mode.
    """
    M, K, G = rest_matrices(model)
    scale = float(eigh(omega**2 * M - G, K, eigvals_only=True)[-1])
    if scale <= 0.0:
        raise DataError(
            f"the first mode has {omega / (2 * np.pi):.3g} Hz: "
            f"gravity alone makes a body of {model.L.sum():.3g} m faster"
        )
    return scale


def tracking_gains(body: Actuator, rate: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """K_o [N/m] and B_o [N s/m] of the offline observer, along the body and across it, that suit the moved mass.

    A cantilever's first mode has a quarter of its body's.
    """
    moved = body.tip_load + body.mass / 4
    return (0.0, moved * rate**2), (0.0, 2.0 * moved * rate)


def _tracking(body: Actuator, shape: Shape, rate: float) -> Tracking:
    """The body's frame with gains that suit the moved mass, release and scatter."""
    frame, mass, load = body.tracking, body.mass, body.tip_load
    assert frame is not None
    K_o, B_o = tracking_gains(body, rate)
    hold = np.exp(shape.hold + shape.slope * np.linspace(-1.0, 1.0, len(frame.arcs)))
    return frame.model_copy(
        update={
            "K_o": K_o,
            "B_o": B_o,
            "hold": tuple((hold * (mass + load) * 9.81 * frame.arcs[-1]).tolist()),
            "release": (shape.delay, float(np.exp(shape.fade))),
        }
    )
