"""The rig's own bounds on a planned reference, whichever server sends it."""

from collections.abc import Sequence

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError
from controller.kernels.control.inverse import TOLERANCE
from controller.kernels.memory import Control
from controller.link import PlannedRows
from controller.reference.feasible.approach import follow
from controller.reference.feasible.bounds import Limits, place_of_row, stretches, worst
from controller.reference.feasible.reach import static_tips
from controller.schema.messages import ControllerInfo
from controller.schema.modes import RowKind
from controller.schema.parameters import ControllerParameters, Settings

COORDINATE_MAX = 2.0
"""[m]"""
OFF_MAX = 10.0 * TOLERANCE
"""So far from its point may the tip be that a row's torques hold [m]."""
ADMISSIBLE = 1e-6
"""Share by which rounding may exceed an admissible torque."""


def require_sound(rows: PlannedRows, room: int) -> None:
    """ParameterError with field, place, value and bound for rows that are not a reference at all."""
    points, count = rows.points, len(rows.points)
    if not 0 < count <= room:
        raise ParameterError(f"reference of {count} points is outside [1, {room}]")
    far = np.flatnonzero(~(np.abs(points) <= COORDINATE_MAX).all(axis=1))
    if far.size:
        raise ParameterError(
            f"points[{far[0]}] = ({points[far[0], 0]:g}, {points[far[0], 1]:g}): the reference holds a coordinate "
            f"outside [-{COORDINATE_MAX}, {COORDINATE_MAX}] m"
        )
    if rows.kinds is not None and not np.isin(rows.kinds, [*RowKind]).all():
        raise ParameterError(f"kinds of {count} points are not all in [{min(RowKind):d}, {max(RowKind):d}]")
    laps = [(rows.planned, count), (rows.planned_again, count - rows.again)]
    if any(planned is not None and planned.shape != (expected, 2) for planned, expected in laps):
        raise ParameterError(f"planned torques do not go with the reference of {count} points")
    if not 0 <= rows.again < count or rows.ticks is None or rows.ticks < 1:
        raise ParameterError(f"reference of {count} points cannot go on at {rows.again} for {rows.ticks} ticks")


def require_followable(rows: PlannedRows, u: Array, control: Control, bounds: ControllerParameters) -> None:
    """ParameterError with field, place, value and bound for rows that the arm cannot follow within the rig's `bounds`.

    Rows without torques are followed from the torques u (2,) [N m] at which the rig is. Of what declares steps only the
    torques are judged.
    """
    torques = rows.torques
    for name, planned in (("planned", rows.planned), ("planned_again", rows.planned_again)):
        if planned is not None:
            _require_admissible(name, planned, control)
    if torques is not None:
        _require_held(rows.points, torques, control)
    if rows.steps:
        return
    torques = follow(control.smap, rows.points, u)[0] if torques is None else torques
    limits = Limits(bounds.reference_speed_max, bounds.reference_acceleration_max, bounds.torque_slew_max)
    for row in stretches(len(rows.points), rows.again, rows.ticks or len(rows.points), bounds.dt):
        if found := worst(rows.points[row], torques[row], limits, bounds.dt):
            at = int(row[found.row])
            raise ParameterError(f"points[{at}], {place_of_row(rows.points, at, bounds.dt)}: {found}, the rig's bound")


def put_planned(rows: PlannedRows, control: Control) -> None:
    """Put the planned torques in place, those of further laps behind them; nan where none are given.

    In place: control.slot.planned.
    """
    count, again = len(rows.points), len(rows.points) - rows.again
    planned = control.slot.planned
    planned[:count] = np.nan if rows.planned is None else rows.planned
    room = min(again, len(planned) - count)
    planned[count : count + room] = np.nan if rows.planned_again is None else rows.planned_again[:room]


def mistuned(settings: Settings, controllers: Sequence[ControllerInfo]) -> str:
    """Why these settings choose no controller of the rig, or tune it out of its bounds; "" where they do neither."""
    if not controllers:
        return ""  # a rig of an older version: there was one
    if settings.controller >= len(controllers):
        return f"refused: controller = {settings.controller} is outside [0, {len(controllers) - 1}]"
    chosen = controllers[settings.controller]
    if chosen.refused:
        return f"refused: controller {chosen.name}: {chosen.refused}"
    for about, value in zip(chosen.tuning, settings.tuning, strict=False):
        if not about.low <= value <= about.high:
            bounds = f"[{about.low:g}, {about.high:g}] {about.unit}"
            return f"refused: {chosen.name}: {about.name} = {value:g} is outside {bounds}"
    return ""


def _require_admissible(name: str, u: Array, control: Control) -> None:
    polygon = control.smap.polygon
    over = u @ polygon.normals.T > polygon.bounds * (1.0 + ADMISSIBLE)
    bad = np.flatnonzero(over.any(axis=1) | ~np.isfinite(u).all(axis=1))
    if bad.size:
        raise ParameterError(f"{name}[{bad[0]}] = ({u[bad[0], 0]:g}, {u[bad[0], 1]:g}) N m is not admissible")


def _require_held(p: Array, u: Array, control: Control) -> None:
    _require_admissible("torques", u, control)
    off = np.hypot(*(static_tips(control.smap, u) - p).T)
    worst_row = int(off.argmax())
    if off[worst_row] > OFF_MAX:
        raise ParameterError(
            f"torques[{worst_row}] hold the tip {1e3 * off[worst_row]:.3g} mm from points[{worst_row}], "
            f"more than {1e3 * OFF_MAX:g} mm"
        )
