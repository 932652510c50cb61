"""The signals that can be exported: every number of a telemetry row, by a flat name."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from controller.errors import ParameterError
from controller.schema.layout import Model, quantity, record_dtype
from controller.schema.messages import Telemetry
from controller.schema.titles import title
from recordings.format.messages import Recording

GROUPS = {
    "tip": ("target", "p_ref", "p_ref_dot", "p_meas", "p_hat", "error", "integral", "residual"),
    "torques": ("u", "u_ff", "u_fb", "u_hat"),
    "pressures": ("pressure_cmd", "pressure_meas"),
    "observer": ("energy", "power", "ledger"),
    "timing": (
        "tick",
        "slot",
        "t_ns",
        "lost",
        "lateness_ns",
        "step_ns",
        "measurement_age",
        "operator_age",
        "server_age",
    ),
    "markers": ("markers",),
    "backbone": ("backbone",),
    "twin_backbone": ("twin_backbone",),
}
"""Fields that belong together; all others are the group "state"."""


TIP = ("tick", "t_ns", "p_meas")
"""All that is known of a path that was imported."""


class SignalInfo(Model):
    """One signal of a recording, as the page offers it for export."""

    name: str
    title: str
    """Its field in words, as on the page."""
    field: str
    """Field of telemetry that it is a number of; its name stands for all of them."""
    unit: str
    """SI; "1" where there is none."""
    group: str


@dataclass(frozen=True)
class Signal:
    """One number of a telemetry row."""

    name: str
    field: str
    index: tuple[int, ...]
    """Where it is in the field, () where that is one number."""

    @property
    def title(self) -> str:
        """Its field in words."""
        return title(self.field)

    @property
    def unit(self) -> str:
        """SI unit, "1" where there is none."""
        return quantity(Telemetry, self.field).unit

    @property
    def group(self) -> str:
        """Key of GROUPS, or "state"."""
        return next((group for group, fields in GROUPS.items() if self.field in fields), "state")


def offered(recording: Recording) -> list[SignalInfo]:
    """What to choose from, as far as that can be said without opening the file."""
    fields = TIP if recording.imported else tuple(Telemetry.model_fields)
    return [
        SignalInfo(name=one.name, title=one.title, field=one.field, unit=one.unit, group=one.group)
        for one in chosen((), fields)
        if recording.twin or one.field != "twin_backbone"
    ]


def chosen(names: Iterable[str], fields: Iterable[str]) -> tuple[Signal, ...]:
    """The signals of these names among those of `fields`, in the order of the names; all of them without names.

    The name of a field stands for all its signals. ParameterError names one that is not there.
    """
    there = [signal for signal in SIGNALS if signal.field in set(fields)]
    found: dict[str, Signal] = {} if names else {signal.name: signal for signal in there}
    for name in names:
        meant = [signal for signal in there if name in (signal.name, signal.field)]
        if not meant:
            known = ", ".join(dict.fromkeys(signal.field for signal in there))
            raise ParameterError(f"signals = {name[:60]}: this recording has no such signal (it has {known})")
        found |= {signal.name: signal for signal in meant}
    return tuple(found.values())


def _signals(field: str) -> Iterator[Signal]:
    """`p_meas_x`, `u_1`, `markers_10_x`, `backbone_0_y`: rods and chambers from 1 on, points of a backbone from 0."""
    plane = quantity(Telemetry, field).unit in ("m", "m/s", "m s")
    first = 0 if field.endswith("backbone") else 1
    for index in np.ndindex(record_dtype(Telemetry)[field].shape):
        words = [str(number + first) for number in index]
        if index and plane:
            words[-1] = "xy"[index[-1]]
        yield Signal("_".join([field, *words]), field, index)


SIGNALS = tuple(signal for field in Telemetry.model_fields for signal in _signals(field))
