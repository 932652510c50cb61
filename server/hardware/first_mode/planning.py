"""What this room asks the planner for: the size of a step, and the fit."""

from typing import TYPE_CHECKING

import numpy as np

from controller.arrays import Rows
from controller.schema.parameters import RigParameters
from server.hardware.first_mode.messages import FirstModeBody, Interval, MeasuredMode
from server.rig.numbered import in_slots

if TYPE_CHECKING:
    from controller.simulation.first_mode import FirstMode


def torque(travel: float, rig: RigParameters) -> float:
    """Torque of both pairs [N m] to either side for `travel` [m]; ParameterError where that is too much."""
    from controller.simulation.first_mode import step_torque

    return step_torque(travel, rig)


def measured(rows: Rows, slots: tuple[int, ...], body: FirstModeBody, rig: RigParameters) -> MeasuredMode:
    """The first mode by telemetry rows (n,) with steps from each of `slots` to the next.

    Raises ParameterError with the reason where they do not tell it.
    """
    from controller.simulation.first_mode import StepRecord, driving_torque, first_mode, mode_model

    grid = np.arange(slots[0], slots[-1])
    rows = rows[in_slots(rows["slot"], grid)]
    driven, pressures = driving_torque(rows["pressure_meas"], rows["u_hat"], rig)
    starts = tuple(slot - slots[0] for slot in slots[:-1])
    record = StepRecord(rig.controller.dt, driven, rows["p_meas"].copy(), starts)
    return as_message(first_mode(record, mode_model(rig)), pressures, body.travel, body.repeats)


def as_message(found: "FirstMode", pressures: bool, travel: float, repeats: int) -> MeasuredMode:
    """The first mode that was `found`, by measured `pressures` or not, from `repeats` of a `travel` [m]."""
    return MeasuredMode(
        **{name: Interval(**getattr(found, name)._asdict()) for name in ("frequency", "zeta", "kappa")},
        friction=found.friction,
        delay=found.delay,
        misfit=found.misfit,
        pressures=pressures,
        travel=travel,
        repeats=repeats,
    )
