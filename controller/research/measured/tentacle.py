"""A hanging tentacle that two tendons bend: where four markers come to rest, after a fit to six of 22 poses.

Each pose is planar, in the plane of both tendons' resultant moment: the section is round and gravity points along the
rest. So the planar rod says where it is, and the plane is turned into space.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from controller.arrays import Array
from controller.assembly.equilibrium import body_of, carrying, settle
from controller.assembly.rod import build_rod
from controller.errors import DataError
from controller.kernels.model.rod import RodModel
from controller.research.measured.sets import Answer, MeasuredSet, Question
from controller.schema.actuator import Actuator

FILE = "paper_results/secVa_system_identification/data/measured_pts.npy"
RODS, LENGTH, TAPER_ENDS = 36, 0.36, 0.305
"""The thin tip begins at TAPER_ENDS [m]."""
RADII = (0.01541, 0.00642, 0.00480)
"""At the base, where the thin tip begins, and at its end [m]."""
ANGLES = np.radians([30.0, 150.0])
"""Of the tendons about the axis."""
TENDON = (0.0114, 0.0295)
"""Distance of both from the axis at the base [m], and how much of it they lose per length."""
REEL = 0.0325
"""Radius of the motors' reels [m]: the files name torques [N m]."""
TORQUES = np.array(
    [(m, 0.0) for m in (0.10, 0.15, 0.20, 0.25)]
    + [(0.0, m) for m in (0.10, 0.15, 0.20, 0.25)]
    + [(m, 0.0) for m in (0.05, 0.12, 0.18)]
    + [(0.0, m) for m in (0.05, 0.12, 0.18)]
    + [(0.1, 0.1), (0.2, 0.2), (0.1, 0.2), (0.15, 0.2), (0.2, 0.1), (0.2, 0.15), (0.1, 0.05), (0.05, 0.1)]
)
"""Of both motors in each pose [N m], in the order of the file."""
FITTED = (0, 2, 4, 6, 14, 15)
"""Two by each tendon alone, two by both alike."""
ARCS = np.array([0.1291, 0.2195, 0.2800, 0.3600])
OFFSETS = np.array([[0.025, 0.0, 0.0], [-0.021, 0.0, 0.0], [0.020, 0.0, 0.0], [0.0, 0.0, 0.008]])
"""Where the markers sit: along the axis (4,) [m], and from it (4,3): across in two directions and along [m]."""
FIRST = np.array([4e5, 1300.0, 1.0, 0.0, 0.0, 0.5])
"""Young's modulus [Pa], density [kg/m^3], second tendon's share of the first, the base's lean in two directions [rad],
and axial compliance in units of 1/(EA), from which the fit begins."""
SCALE = np.array([1e5, 300.0, 0.1, 0.05, 0.05, 0.5])
BY_OTHERS = {"their rod, fitted on 8 poses": 15.8, "their rod and a network fitted on all 22": 6.1}
"""As published with the data, over all 22 poses [mm]."""


def answers(paths: Mapping[str, Path]) -> list[Answer]:
    """Rms distance of the markers [mm]: in the 16 poses that were not fitted, and in all."""
    measured = _measured(paths[FILE])
    rigid, soft = (_fitted(measured, stretch=stretch) for stretch in (False, True))
    unseen, every = [n for n in range(len(TORQUES)) if n not in FITTED], range(len(TORQUES))
    return [
        Answer(_rms_mm(measured, soft, which), {"without stretch": _rms_mm(measured, rigid, which), **others})
        for which, others in ((unseen, {}), (every, BY_OTHERS))
    ]


def _measured(path: Path) -> Array:
    try:
        found = np.load(path)
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: no array of numpy: {error}") from error
    if found.shape != (len(TORQUES), len(ARCS), 3) or not np.isfinite(found).all():
        raise DataError(f"{path}: {found.shape} is not ({len(TORQUES)}, {len(ARCS)}, 3): poses, markers, x y z [m]")
    return np.asarray(found)


def _fitted(measured: Array, *, stretch: bool) -> Array:
    free = np.array([True] * 5 + [stretch])

    def numbers(x: Array) -> Array:
        whole = np.where(free, FIRST, 0.0)
        whole[free] += x * SCALE[free]
        return np.asarray(whole)

    def off(x: Array) -> Array:
        return np.concatenate([(markers(numbers(x), TORQUES[n]) - measured[n]).ravel() for n in FITTED])

    return numbers(least_squares(off, np.zeros(free.sum())).x)


def _rms_mm(measured: Array, numbers: Array, which: Sequence[int]) -> float:
    off = [np.linalg.norm(markers(numbers, TORQUES[n]) - measured[n], axis=1) for n in which]
    return float(1e3 * np.sqrt(np.mean(np.square(off))))


def markers(numbers: Array, torques: Array) -> Array:
    """Places of the markers (4,3) [m] under the torques of both motors (2,) [N m]; `numbers` as FIRST."""
    E, density, second, lean_x, lean_y, compliance = numbers
    tension = torques / REEL * np.array([1.0, second])
    pull = tension @ np.column_stack([np.sin(ANGLES), np.cos(ANGLES)])
    across = pull / np.linalg.norm(pull)
    h = LENGTH / RODS
    middles = np.asarray(h * (np.arange(RODS) + 0.5))
    theta = _pose(E, density, float(np.linalg.norm(pull)))
    area = np.pi * _radius(middles) ** 2
    reach = h * (1.0 - compliance * tension.sum() / (E * area) * (middles < TAPER_ENDS))
    steps = reach[:, None] * np.column_stack([np.sin(theta), -np.cos(theta)])
    ends = np.vstack([np.zeros(2), steps.cumsum(axis=0)])
    at = np.column_stack([np.interp(ARCS, h * np.arange(RODS + 1), ends[:, j]) for j in (0, 1)])
    angle = np.interp(ARCS, middles, theta)
    in_plane = OFFSETS[:, :2] @ across
    out = OFFSETS[:, :2] - in_plane[:, None] * across
    r = at[:, 0] + in_plane * np.cos(angle) + OFFSETS[:, 2] * np.sin(angle)
    z = at[:, 1] + in_plane * np.sin(angle) - OFFSETS[:, 2] * np.cos(angle)
    lean = np.array([[1.0, 0.0, -lean_x], [0.0, 1.0, -lean_y], [lean_x, lean_y, 1.0]])
    return np.asarray(np.column_stack([r[:, None] * across + out, z]) @ lean)


def _pose(E: float, density: float, pull: float) -> Array:
    """Angles (RODS,) [rad] from straight down."""
    first = _first_rod()
    model = first._replace(k=E / FIRST[0] * first.k, m=density / FIRST[1] * first.m)
    hinges = LENGTH / RODS * np.arange(RODS)
    carried = pull * np.where(hinges < TAPER_ENDS, TENDON[0] - TENDON[1] * hinges, 0.0)
    return settle(carrying(body_of(model), carried - np.append(carried[1:], 0.0)), model.rest)


@cache
def _first_rod() -> RodModel:
    """The tentacle with the modulus and the density of FIRST."""
    arcs = np.linspace(0.0, LENGTH, RODS)
    section = np.pi * _radius(arcs) ** 2
    actuator = Actuator.model_validate(
        {
            "name": "tentacle",
            "mass": float(FIRST[1] * np.trapezoid(section, arcs)),
            "length": LENGTH,
            "table_rods": RODS,
            "EI": (FIRST[0] * section * _radius(arcs) ** 2 / 4).tolist(),
            "EI_arc": arcs.tolist(),
            "beta": 1e-3,
            "mass_profile": (section / section[0]).tolist(),
            "gravity": (9.81, 0.0),
        }
    )
    return build_rod(actuator, RODS)


def _radius(s: Array) -> Array:
    return np.asarray(np.interp(s, (0.0, TAPER_ENDS, LENGTH), RADII))


QUESTION = "four markers at rest, after a fit to six planar poses"
TENTACLE = MeasuredSet(
    name="hanging tentacle",
    source="github.com/tud-phi/soromox",
    licence="MIT",
    files=(FILE,),
    questions=(
        Question(f"{QUESTION}, in the 16 others", "rms distance", "mm"),
        Question(f"{QUESTION}, in all 22", "rms distance", "mm"),
    ),
    answers=answers,
)
