"""The static map of a rod model as the kernels use it: exact under gravity, too."""

import itertools
from functools import lru_cache

import numpy as np

from controller.arrays import Mask, Words
from controller.assembly.equilibrium import driven_body
from controller.assembly.polygon import build_polygon
from controller.assembly.poses import start_poses
from controller.assembly.rod import build_rod, damped, hastened
from controller.kernels.model.equilibrium import Scratch, make_scratch
from controller.kernels.model.polygon import admissible
from controller.kernels.model.rod import RodModel
from controller.kernels.model.statics import StaticMap, Statics, tips_of
from controller.schema.actuator import Actuator
from controller.schema.parameters import ControllerParameters, usual_twin

SEED_GRID = 41
"""Points a side of the grid of starts for the inverse: 3 mN m, some 10 mm at the tip."""


def build_statics(model: RodModel, u_max: float) -> Statics:
    """Static map of `model` for torques up to `u_max` [N m]; beyond them it begins farther off."""
    statics = Statics(
        L=model.L,
        rest=model.rest,
        compliance=model.compliance,
        body=driven_body(model),
        u_max=u_max,
        starts=np.zeros((0, 0, model.L.size)),
    )
    return statics._replace(starts=start_poses(statics)) if model.g.any() else statics


def build_static_map(model: RodModel, actuator: Actuator, controller: ControllerParameters) -> StaticMap:
    """Static map of `model` over the torques of `actuator`, with a grid of starts for the inverse."""
    statics = build_statics(model, actuator.u_max)
    polygon = build_polygon(actuator, statics)
    side = np.linspace(-actuator.u_max, actuator.u_max, SEED_GRID)
    inside = np.array([[admissible(polygon, u1, u2) for u2 in side] for u1 in side])
    grid, beside = side[np.argwhere(inside)], _neighbours(inside)
    tips = np.zeros_like(grid)
    tips_of(statics, grid, make_scratch(model.L.size), tips)
    ways = np.linalg.norm(tips[beside] - tips[:, None], axis=2)
    return StaticMap(
        statics=statics,
        polygon=polygon,
        epsilon=controller.epsilon,
        rcond_min=controller.rcond_min,
        seeds=grid,
        seed_tips=tips,
        beside=beside,
        spacing=float(side[1] - side[0]),
        reach=float(ways[beside >= 0].max(initial=0.0)),
    )


def _neighbours(inside: Mask) -> Words:
    """For each point of the grid that is inside (n,n) its neighbours (k,8) among those that are, counted along rows."""
    number = np.pad(np.where(inside, np.cumsum(inside).reshape(inside.shape) - 1, -1), 1, constant_values=-1)
    steps = [step for step in itertools.product((0, 1, 2), repeat=2) if step != (1, 1)]
    rows, columns = inside.shape
    around = [number[i : i + rows, j : j + columns][inside] for i, j in steps]
    return np.stack(around, axis=1)


@lru_cache(maxsize=8)
def static_map(actuator: Actuator, controller: ControllerParameters) -> StaticMap:
    """The observer's static map of `actuator`, made once for each; not to be written into."""
    return build_static_map(observer_model(actuator, controller), actuator, controller)


@lru_cache(maxsize=8)
def observer_model(actuator: Actuator, controller: ControllerParameters) -> RodModel:
    """The observer's chain, made once for each; not to be written into. ParameterError where it has no rest."""
    model = build_rod(actuator, controller.rods, omega_B=controller.omega_B, zeta_B=controller.zeta_B)
    return hastened(model, controller.observer_kappa)


@lru_cache(maxsize=8)
def planning_model(actuator: Actuator, controller: ControllerParameters) -> RodModel:
    """The observer's chain, as quick and as damped as the actuator is believed to be.

    As quick as it was measured, which is the observer's kappa where that is not the paper's; of the paper's three, and
    of their damping, what was fitted to them is believed.
    """
    usual, kappa = usual_twin(actuator), controller.observer_kappa
    if kappa == 1.0:
        controller = controller.model_copy(update={"observer_kappa": usual.kappa})
    model = observer_model(actuator, controller)
    return model if usual.zeta is None else damped(model, usual.zeta)


def scratch_for(smap: StaticMap) -> Scratch:
    """Scratch of one caller of `smap`."""
    return make_scratch(smap.statics.L.size)
