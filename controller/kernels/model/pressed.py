"""The chain under pressure: hinges become stiffer and rods longer where the chambers reach.

Not in the paper, where the torques are all that pressure does. Lengths follow the pressures without inertia of their
own: they are as slow as those, and the hinges close on them with every step.
"""

from controller.arrays import Array
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.model.rod import RodModel, under_levels
from controller.kernels.model.statics import Places, pose


class Unpressed(Group):
    """A chain of N rods without pressure, and where points on it lie then."""

    k: Array
    """Stiffness of the hinges (N,) [N m/rad]."""
    L: Array
    """Length of the rods (N,) [m]."""
    arm: Array
    """From their proximal ends to their centres of mass (N,) [m]."""
    markers: Array
    """From its rod's centre to each marker (n,) [m]."""
    backbone: Array
    """From its rod's centre to each of the telemetry's backbone points (n,) [m]."""


def unpressed(model: RodModel, markers: Places, backbone: Places) -> Unpressed:
    """The chain as it was built, kept from what pressure makes of `model` and of the points."""
    return Unpressed(*(a.copy() for a in (model.k, model.L, model.arm, markers.offset, backbone.offset)))


def owning(model: RodModel) -> RodModel:
    """`model` with stiffness and lengths of its own, for pressure to change."""
    return model._replace(k=model.k.copy(), L=model.L.copy(), arm=model.arm.copy())


@kernel
def is_pressed(model: RodModel) -> bool:
    """Whether pressure changes the chain's stiffness or its lengths. Not in the paper: see the module."""
    return model.stiffening.shape[0] + model.stretching.shape[0] > 0


@kernel
def press_chain(
    level_1: float, level_2: float, own: Unpressed, model: RodModel, markers: Places, backbone: Places
) -> None:
    """Stiffness and lengths of the chain at these levels of its pairs' pressures [N m], as of `under_levels`.

    Not in the paper: see the module. In place: model, markers, backbone.
    """
    if model.stiffening.shape[0] > 0:
        under_levels(own.k, model.stiffening, level_1, level_2, model.k)
    if model.stretching.shape[0] > 0:
        under_levels(own.L, model.stretching, level_1, level_2, model.L)
        under_levels(own.arm, model.stretching, level_1, level_2, model.arm)
        carry(own.markers, own.L, model.L, markers)
        carry(own.backbone, own.L, model.L, backbone)


@kernel
def carry(offset: Array, before: Array, after: Array, points: Places) -> None:
    """Move points, `offset` (n,) from their rods' centres [m], with rods of lengths `before` that are now `after` (N,).

    Not in the paper: see the module. In place: points.
    """
    for j in range(offset.size):
        i = points.rod[j]
        points.offset[j] = offset[j] * after[i] / before[i]


@kernel
def close_up(model: RodModel, q: Array) -> None:
    """Move the rods of the pose q (3,N) to where the hinges are closed, after their lengths have changed.

    phi_H(q) = 0: paper, "Constrained Dynamic Model". In place: q.
    """
    if model.stretching.shape[0] > 0:
        pose(model, q[2], q)
