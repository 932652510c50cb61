"""The slot: what a controller is shown in a tick, and what it says; which there are: `controller/assembly/controllers`.

A controller is a kernel `law(now, reference, tuning, memory, out_wanted)`: one record of NOW, the planned reference
(rows,2) [m] with all that is still to come, its own numbers (TUNING,), its memory (MEMORY,), which is 0 when it is
chosen, and one record of WANTED. It is called in every tick, in every mode, by its address: the tick is compiled
without it. Saturation, slew limits, bumpless switching and all safety are around the slot, and not its matter.
"""

import numpy as np

from controller.arrays import Array, Rows, Words
from controller.kernels.group import Group
from controller.schema.slot import SIGNALS

MEMORY = 1024
"""Numbers that it may remember."""

NOW = np.dtype(
    [
        ("dt", "<f8"),  # [s]
        ("law", "<i8"),  # Law: which parts of FF, P and I the operator wants
        ("live", "<i8"),  # HOLD, FOLLOW or TRACK, in closed loop
        ("led", "<i8"),  # by hand, or nothing: not TRACK
        ("closed", "<i8"),  # a tip is seen, and is to be fed back
        ("blending", "<i8"),  # u_ff is on its way to another branch: nothing is fed back
        ("begins", "<i8"),  # the arm was armed, or this controller chosen: `u` holds the arm where it is
        ("switched", "<i8"),  # law, gains or source of the error are not those of the last tick
        ("kind", "<i8"),  # RowKind of the row in force
        ("row", "<i8"),  # of `reference`, in force; -1: none
        ("rows", "<i8"),  # of `reference` in all
        ("again", "<i8"),  # the row that comes after the last one
        ("left", "<i8"),  # rows that are still to be followed
        ("p_ref", "<f8", (2,)),  # reference [m]
        ("p_ref_dot", "<f8", (2,)),  # its rate [m/s]
        ("way", "<f8"),  # of the wish in this tick [m]
        ("tip", "<f8", (2,)),  # as measured last, or its estimate where its marker is not in use [m]
        ("tip_age", "<f8"),  # since that was captured [s]
        ("p_hat", "<f8", (2,)),  # the observer's tip now [m]
        ("error", "<f8", (2,)),  # p_ref - tip [m]
        ("told", "<f8"),  # share of the gains that the markers in use are worth where the tip is led by hand
        ("u_ff", "<f8", (2,)),  # quasi-static feedforward: it holds the model at p_ref [N m]
        ("planned", "<f8", (2,)),  # torques that move the model along the reference; nan without a plan [N m]
        ("u", "<f8", (2,)),  # sent in the last tick [N m]
        ("cut", "<f8", (2,)),  # what of its sum could not be sent [N m]
        ("push", "<f8", (2,)),  # the same as a push against the edge of the admissible torques, at a right angle to it
        ("saturated", "<i8"),
        ("S", "<f8", (4,)),  # sensitivity at the observer's pose, row by row [m/(N m)]
        ("stands", "<i8"),  # whether that pose could be an equilibrium
        ("weak", "<f8", (2,)),  # unit vector along which S is weakest
        ("share", "<f8"),  # of feedback along it that is let through
        ("epsilon", "<f8"),  # of the regularised inverse of S
        ("K_P", "<f8", (2,)),
        ("K_I", "<f8", (2,)),
        ("K_FF", "<f8", (2,)),  # in force: the settings', or the reference's own
        ("feedback_lag", "<f8"),  # with which P follows the error where the tip is led by hand [s]
        ("dead_time", "<f8"),  # of the air lines, as the observer has it [s]
        ("pneumatic_lag", "<f8"),  # of the chambers [s]
        ("u_max", "<f8"),  # most torque of a pair of chambers [N m]
        ("tip_used", "<i8"),  # `tip` is measured: its own marker is in use
    ]
)
"""What a controller is shown, one record."""

WANTED = np.dtype(
    [
        ("u_ff", "<f8", (2,)),  # feedforward [N m]; `now.u_ff` unless the controller says otherwise
        ("u_fb", "<f8", (2,)),  # feedback [N m]: it counts while the loop is closed
        ("by_tip", "<i8"),  # 1: torques are cut where that moves the tip least; 0: where they change least
        ("integral", "<f8", (2,)),  # of the error, as it is shown [m s]
        ("signals", "<f8", (SIGNALS,)),  # shown and recorded
    ]
)
"""What it says, one record."""


class Slot(Group):
    """The controllers of a rig, and what goes between them and the tick."""

    laws: Words
    """(n,) addresses of the compiled controllers."""
    now: Rows
    wanted: Rows
    memory: Array
    """(MEMORY,)"""
    planned: Array
    """(rows,2) torques [N m] that move the model along the planned reference; nan where none were planned."""
