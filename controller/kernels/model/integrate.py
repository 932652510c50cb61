"""Fixed-step integration of the rod chain."""

from controller.arrays import Array
from controller.kernels.compiled import flushed, inlined, kernel
from controller.kernels.model.rod import Load, RodModel, RodState, Work, accelerate


@kernel
def rk4_step(model: RodModel, load: Load, dt: float, state: RodState, work: Work) -> None:
    """Advance `state` by dt [s] under a held load: classical Runge-Kutta (paper, "Hardware setup": ode4).

    Order: 4, in pose and velocity.
    Stability: dt |s| < 2.79 for damped modes s, < 2.83 for ringing ones; the finest rods' hinge dampers set the bound,
    which falls with N^4. `stability.largest_step` finds it, `implicit_step` has none.
    Energy: neither kept nor bounded: below the bound it loses, at order dt^5 ((dt |s|)^6 / 72 of a ringing
    mode's energy a step), beyond it gains and diverges. Hinges drift by the step's error and Baumgarte pulls them back.
    The stages stay in `work` (q, v, acc, lam, a): the energy ledger reads them. In place: state, work.
    """
    fill_first_stage(state, work)
    accelerate(model, load, 0, work)
    for stage in range(1, 4):
        fill_stage(state, stage, dt if stage == 3 else 0.5 * dt, work)
        accelerate(model, load, stage, work)
    finish_step(work.acc, dt, state)


@inlined
def fill_first_stage(state: RodState, out_work: Work) -> None:
    """The first stage, the state itself, into out_work.q[0] and .v[0] (paper, "Hardware setup": ode4)."""
    for row in range(3):
        for i in range(state.q.shape[1]):
            out_work.q[0, row, i] = state.q[row, i]
            out_work.v[0, row, i] = state.v[row, i]


@inlined
def fill_stage(state: RodState, stage: int, h: float, work: Work) -> None:
    """State of a later stage: h [s] from the start along the slope of the stage before (paper, "Hardware setup": ode4).

    In place: work.q, work.v.
    """
    for row in range(3):
        for i in range(state.q.shape[1]):
            work.q[stage, row, i] = state.q[row, i] + h * work.v[stage - 1, row, i]
            work.v[stage, row, i] = state.v[row, i] + h * work.acc[stage - 1, row, i]


@inlined
def finish_step(acc: Array, dt: float, state: RodState) -> None:
    """dt [s] along the weighted mean 1 : 2 : 2 : 1 of the stages' slopes, acc (4,3,N) (paper, "Hardware setup": ode4).

    In place: state.
    """
    for row in range(3):
        for i in range(state.q.shape[1]):
            early = acc[0, row, i] + acc[1, row, i] + acc[2, row, i]
            late = acc[1, row, i] + acc[2, row, i] + acc[3, row, i]
            state.q[row, i] = flushed(state.q[row, i] + dt * state.v[row, i] + dt * dt / 6.0 * early)
            state.v[row, i] = flushed(state.v[row, i] + dt / 6.0 * (early + late))
