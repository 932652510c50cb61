"""What the controller remembers from tick to tick, and the groups of arrays that the stages of the tick are handed."""

import numpy as np

from controller.arrays import Array, Rows, Words
from controller.kernels.group import Group
from controller.kernels.model.equilibrium import Scratch
from controller.kernels.model.statics import StaticMap
from controller.kernels.slot import Slot

STATE = np.dtype(
    [
        ("boot", "<i8"),
        ("tick", "<i8"),
        ("start_ns", "<i8"),
        ("last_ns", "<i8"),
        ("stall_ns", "<i8"),  # the loop's last stall, from here
        ("resume_ns", "<i8"),  # to here: silence in it is not held against anyone
        ("mode", "<i8"),
        ("cause", "<i8"),
        ("entered", "<i8"),  # 1 in the tick in which the mode changed
        ("begins", "<i8"),  # 1 in the tick in which it became a live one: u led the arm until then
        ("request_n", "<i8"),
        ("request_cause", "<i8"),
        ("presence", "<i8"),
        ("presence_ns", "<i8"),
        ("unattended", "<i8"),
        ("used", "<i8"),  # sensors used in this tick, as bits
        ("forget", "<i8"),  # the observer is to start again
        ("forgot_ns", "<i8"),  # time of the last CLEAR, which asked for it
        ("moved_over", "<i8"),  # it is on its way to another pose
        ("seen_ns", "<i8"),  # capture time of the last sample with a marker that is wanted
        ("jumped", "<i8"),  # switched-on sensors that jumped in the last sample, as bits
        ("moved_ns", "<i8"),  # capture time of the last sample in which a marker was not where it was before
        ("u_moved", "<f8", (2,)),  # torque on the model at that time [N m]
        ("off_time", "<f8"),  # time with the tracking error above its limit, less that below it [s]
        ("error_slow", "<f8", (2,)),  # mean of the error over a short window [m]
        ("error_lag", "<f8", (2,)),  # by how much it lags behind: what is left without both swings [m]
        ("ref_slow", "<f8", (2,)),  # the same of the reference
        ("ref_lag", "<f8", (2,)),
        ("swing", "<f8"),  # windowed mean square of the error's swing [m^2]
        ("swing_ref", "<f8"),  # the same of the reference's
        ("swing_held", "<f8"),  # the most that this was lately
        ("swing_off", "<f8"),  # time with the error's swing above its limit, less that below it [s]
        ("error_mean", "<f8", (2,)),  # mean of the error over the window of its rms [m]
        ("error_square", "<f8"),  # mean square of the error over it [m^2]
        ("error_first", "<f8"),  # square of the error when the loop was closed, as far as it still counts in it [m^2]
        ("residual_off", "<f8"),  # time with the residual above its limit, less that below it [s]
        ("pressure_off", "<f8"),  # the same for the pressures' distance from the model [s]
        ("chamber_shown", "<f8", (4,)),  # pressure at which each reading stands still [Pa]
        ("chamber_asked", "<f8", (4,)),  # what the torques asked of it when it moved last [Pa]
        ("chamber_still", "<f8", (4,)),  # time with its reading still, and off what is asked since [s]
        ("index", "<i8"),  # next row of the planned reference
        ("followed", "<i8"),  # rows of it taken so far
        ("row", "<i8"),  # of it, in force
        ("planned_row", "<i8"),  # place of its planned torques: every lap but the first has those of the second
        ("guided", "<i8"),  # the row in force names its torques
        ("kind", "<i8"),  # RowKind of the row in force; DRAWN in any other mode than TRACK
        ("aimed", "<f8", (2,)),  # where the goal has stood still [m]
        ("aimed_tick", "<i8"),  # since this tick
        ("aimed_time", "<f8"),  # for so long [s]
        ("reachable", "<i8"),  # the goal is in reach
        ("reached", "<i8"),  # the static tip of u_ff is at the wish
        ("blending", "<i8"),  # u_ff is on its way to another branch
        ("blend_rate", "<f8"),  # [N m/s]
        ("u_goal", "<f8", (2,)),  # static inverse of the goal
        ("p_goal", "<f8", (2,)),  # the goal, or the nearest reachable point
        ("wish", "<f8", (2,)),  # on its way to p_goal under the limits of speed and acceleration
        ("wish_dot", "<f8", (2,)),
        ("acceleration", "<f8"),  # limit of the wish's acceleration in force [m/s^2]
        ("p_ref", "<f8", (2,)),
        ("p_ref_dot", "<f8", (2,)),
        ("u_ff", "<f8", (2,)),
        ("u_fb", "<f8", (2,)),
        ("u", "<f8", (2,)),
        ("S", "<f8", (4,)),  # sensitivity at the observer's pose, row by row
        ("stands", "<i8"),  # the observer's pose could be an equilibrium: no weight would topple it
        ("weak", "<f8", (2,)),  # unit vector in the task space along which S is weakest
        ("share", "<f8"),  # of the feedback along it that is let through
        ("bump", "<f8", (2,)),  # what keeps u continuous at a switch; decays
        ("cut", "<f8", (2,)),  # what of u_ff + u_fb could not be sent in the last tick [N m]
        ("push", "<f8", (2,)),  # the same, against the edge of the admissible torques at a right angle
        ("saturated", "<i8"),  # something was cut
        ("controller", "<i8"),  # in force
        ("told", "<f8"),  # what the markers in use tell of the tip, as a share of P and I
        ("scheme", "<i8"),  # law, source of the error and gains as of the last tick, to notice a switch
        ("gains", "<f8", (6,)),
        ("K_FF", "<f8", (2,)),  # in force: the settings', or the reference's own
    ]
)
"""Memory of the controller, one record."""
PLAN = np.dtype(
    [
        ("rows", "<i8"),  # of the planned reference in force; 0: none is planned
        ("again", "<i8"),  # row that comes after the last one
        ("ticks", "<i8"),  # to follow in all
    ]
)
"""How the planned reference is followed, one record."""


class Control(Group):
    """What the stages after the observer need."""

    dt: float
    """Period of the tick [s]."""
    controller: Rows
    """ControllerParameters, one record."""
    limits: Rows
    """SafetyLimits, one record."""
    pascal_per_torque: Array
    """Pressure of each chamber per u_j (4,) [Pa/(N m)]."""
    smap: StaticMap
    scratch: Scratch
    """Of the loop's thread, for the static map."""
    q: Array
    """The observer's pose (3,N)."""
    v: Array
    """The observer's velocity (3,N)."""
    reference: Array
    """Planned reference for TRACK (rows,2) [m], one row a tick."""
    guide: Array
    """Torques (rows,2) [N m] that hold the tip at the rows of `reference`; nan where the tick is to find them."""
    slot: Slot
    kinds: np.ndarray
    """RowKind (rows,) of the rows of `reference`."""
    plan: Rows
    """PLAN, one record; like the reference written only while the rig is not in TRACK."""
    state: Rows
    """STATE, one record."""


class Sensing(Group):
    """The last sample of the markers, held for the controller, carried on to the present for the observer."""

    sample_ns: Words
    """(1,) its time of capture; 0 before the first."""
    p: Array
    """Positions (10,2) [m], nan where not seen, or where the marker jumped."""
    v: Array
    """Velocities by difference of the last two samples that did not come together (10,2) [m/s], 0 where unknown."""
    seen: Array
    """Positions when each was seen last (10,2) [m], used or not; nan where that tells nothing."""
    seen_dot: Array
    """Velocities at that time (10,2) [m/s], 0 where unknown."""
    usual: Array
    """(1,) the usual time between two samples [s]."""
    gap: Array
    """(1,) the time before the last sample that did not come together with another [s]."""
    held: Array
    """(1,) for how long the last sample may have been held back on its way; 0 if it came in its time [s]."""
    late: Array
    """(1,) by how much later than this one the sample before was stamped, for all that is usual [s]."""
    age: Array
    """(1,) by how long the observer carries p on with v, to the middle of the coming step; 0 where it holds p [s]."""
    off: Array
    """Each marker's distance from the model in the last sample that was used (10,2) [m]; nan before the first."""
    fast: Array
    """(1,) the highest speed of any marker or of the model's tip, fading [m/s]."""
    met_ns: Words
    """(10,) capture time of the last sample in which each marker was seen, used or not."""
    dropped: Words
    """(1,) int64: bit i-1 set: the marker of rod i jumped, and is not used."""
