"""What the model makes of torques that are to come, and by how much they have to change for the tip to be elsewhere."""

from controller.arrays import Array
from controller.kernels.compiled import kernel
from controller.kernels.model.equilibrium import Scratch
from controller.kernels.model.implicit import implicit_step
from controller.kernels.model.polygon import nearest_admissible
from controller.kernels.model.sensitivity import expand_tip
from controller.kernels.model.statics import StaticMap, tip_of
from controller.kernels.observer.observer import Observer, advance_pneumatics, believe_torques, pressurise


@kernel
def foresee_tip(u: Array, model: Observer, out_p: Array) -> None:
    """Tip (n,2) [m] of the model, which no marker pulls, as each of the torques u (n,2) [N m] is sent.

    Through dead time and lag (paper, "Dynamic observer"). In place: model.
    """
    for k in range(u.shape[0]):
        out_p[k, 0], out_p[k, 1] = tip_of(model.model, model.state.q)
        advance_pneumatics(u[k, 0], u[k, 1], model)
        believe_torques(model)
        pressurise(model)
        implicit_step(model.model, model.load, model.dt, model.state, model.implicit_work)


@kernel
def move_torques(f: Array, weak: float, smap: StaticMap, scratch: Scratch, u: Array) -> None:
    """Add to the torques u (n,2) [N m] what moves the static tip by f (n,2) [m], and take the nearest admissible ones.

    (S^T S + (weak sigma_1)^2 I)^-1 S^T f with the S of each: a direction in which S is weaker than the share `weak` of
    its strongest is left alone. Eq. UFB: paper, "Task-space PI control", has epsilon there. In place: u, scratch.
    """
    for k in range(u.shape[0]):
        at = expand_tip(smap.statics, u[k, 0], u[k, 1], scratch)
        H11, H12, H22 = (
            at.x_1 * at.x_1 + at.y_1 * at.y_1,
            at.x_1 * at.x_2 + at.y_1 * at.y_2,
            at.x_2 * at.x_2 + at.y_2 * at.y_2,
        )
        least = weak * weak * (H11 + H22)
        H11, H22 = H11 + least, H22 + least
        g_1, g_2 = at.x_1 * f[k, 0] + at.y_1 * f[k, 1], at.x_2 * f[k, 0] + at.y_2 * f[k, 1]
        det = H11 * H22 - H12 * H12
        u_1, u_2 = u[k, 0] + (H22 * g_1 - H12 * g_2) / det, u[k, 1] + (H11 * g_2 - H12 * g_1) / det
        u[k, 0], u[k, 1] = nearest_admissible(smap.polygon, u_1, u_2)
