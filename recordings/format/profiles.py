"""The two profiles: how much of every tick a recording keeps, how finely, and what that costs on the disk.

A row of an rrd entity costs some 30 bytes before its first number (timelines, an id, an offset). So `standard`
puts what it keeps of every tick into one entity, and writes the entities that the viewer plots at 100 Hz.
"""

import numpy as np

from controller.arrays import Rows
from controller.schema.layout import Model, quantity
from controller.schema.messages import Telemetry
from recordings.format.messages import Profile
from recordings.format.signals import GROUPS, Group

RESOLUTION = {"m": 2.0**-17, "Pa": 8.0, "N m": 2.0**-17, "ns": 1024.0}
"""Steps to which `standard` rounds fields of these units: 7.6 um, 8 Pa, 7.6 uN m, 1 us. Powers of two compress best.

The twin's camera has a noise of 100 um, a pressure sensor one of some 100 Pa.
"""

FINER = {"p_ref": 2.0**-23}
"""Of the reference, which has no noise: 7.6 um from tick to tick are 8 mm/s, and it is judged against limits."""
CLOCK = "t_ns"
"""Is never rounded: it is the time line."""

SLOW_FIELDS = frozenset(
    (
        "energy ledger power u_hat presence p_ref_dot integral measurement_age operator_age server_age reseats "
        "controller signals"
    ).split()
)
"""What `standard` keeps at 100 Hz only, beside the backbones."""

TICKS = Group("/ticks", tuple(series for group in GROUPS for series in group.series if series.field not in SLOW_FIELDS))
"""Everything that `standard` keeps of every tick, in one entity."""


class ProfileInfo(Model):
    """One profile, as the page offers it."""

    name: Profile
    meaning: str
    megabytes_per_hour: int
    """Of a closed and compacted file of the twin in TRACK; measured by `python -m recordings.size`."""


PROFILES = (
    ProfileInfo(
        name="standard",
        meaning="Tip, reference, error, commands, pressures, timing and state at 1 kHz, the rest at 100 Hz; rounded to "
        "0.01 mm, 10 Pa, 1e-5 N m and 1 us or finer",
        megabytes_per_hour=580,
    ),
    ProfileInfo(
        name="full",
        meaning="Every number of every tick as it is, backbones at 100 Hz",
        megabytes_per_hour=1960,
    ),
)


def meaning(profile: Profile) -> str:
    """What `profile` keeps, in words."""
    return next(info.meaning for info in PROFILES if info.name == profile)


def rounded(rows: Rows) -> Rows:
    """A copy of `rows` (n,) with every field of a unit in RESOLUTION on its steps; nan stays nan."""
    out = rows.copy()
    for field in Telemetry.model_fields:
        step = FINER.get(field) or RESOLUTION.get(quantity(Telemetry, field).unit)
        if step is not None and field != CLOCK:
            out[field] = np.round(rows[field] / step) * step
    return out
