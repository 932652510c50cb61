"""The signals that can be plotted: every number of a telemetry row but its time, and the norms of plane vectors."""

import numpy as np
import numpy.typing as npt

from controller.arrays import Rows
from controller.errors import ParameterError
from controller.schema.layout import fields, numbers, quantity, record_dtype
from controller.schema.messages import Telemetry
from controller.schema.parameters import BACKBONE_POINTS, SENSORS
from server.rig.messages import PlotChannel

TITLES = {
    "p_ref": "reference",
    "p_meas": "measured tip",
    "p_hat": "observer tip",
    "error": "error",
    "residual": "observer residual",
    "pressure_meas": "pressure",
    "pressure_cmd": "pressure command",
    "u": "torque",
    "u_ff": "feedforward torque",
    "u_fb": "feedback torque",
    "u_hat": "observer's torque",
    "integral": "error integral",
    "target": "target",
    "p_ref_dot": "reference speed",
    "energy": "energy",
    "ledger": "energy ledger",
    "power": "power",
    "markers": "markers",
    "backbone": "observer backbone",
    "twin_backbone": "twin backbone",
    "measurement_age": "measurement age",
    "operator_age": "operator age",
    "server_age": "server age",
    "step_ns": "step time",
    "lateness_ns": "wake-up lateness",
    "lost": "lost ticks",
    "tick": "ticks",
    "slot": "time slots",
    "mode": "mode",
    "cause": "cause",
    "law": "law",
    "sensed": "sensors used",
    "saturated": "saturated",
    "reachable": "reachable",
    "command_n": "command number",
    "request_n": "request number",
    "request_cause": "request's cause",
    "presence": "presence counter",
}
"""Every field in words, in the order of the page's menu."""

_XY = ("x", "y")
_ELEMENTS = {
    **{name: ("1", "2") for name in ("u", "u_ff", "u_fb", "u_hat")},
    **{name: ("1", "2", "3", "4") for name in ("pressure_cmd", "pressure_meas")},
    "power": ("damping", "pneumatic", "observer", "Baumgarte"),
    "markers": tuple(f"rod {rod} {axis}" for rod in range(1, SENSORS + 1) for axis in _XY),
    **{
        name: tuple(f"{point}/{BACKBONE_POINTS - 1} L {axis}" for point in range(BACKBONE_POINTS) for axis in _XY)
        for name in ("backbone", "twin_backbone")
    },
}
"""Names of the elements of fields that are not a number or a vector of the plane."""


class UnknownChannel(ParameterError):
    """There is no channel of this key."""


def extract(rows: Rows) -> npt.NDArray[np.float32]:
    """Values of all channels, (n, channels), of n telemetry rows; a norm is that of each row, nan where one is."""
    out = np.empty((len(rows), len(CHANNELS)), np.float32)
    for kind, places, found in _PLAIN:
        out[:, places] = numbers(rows, kind)[:, found]
    plane = numbers(rows, np.float64)
    out[:, _NORMS] = np.hypot(plane[:, _NORMED], plane[:, _NORMED + 1])
    return out


def column(rows: Rows, channel: PlotChannel) -> npt.NDArray[np.float64]:
    """Values (n,) of one channel of n telemetry rows, as exact as they are there."""
    values = rows[channel.field].reshape(len(rows), _width(channel.field)).astype(np.float64)
    return np.hypot(values[:, 0], values[:, 1]) if channel.index is None else values[:, channel.index]


def columns_of(keys: list[str]) -> list[int]:
    """Places of the channels in `CHANNELS`; `UnknownChannel` with the first key that is none."""
    unknown = next((key for key in keys if key not in _PLACES), None)
    if unknown is not None:
        raise UnknownChannel(f"channels = {unknown}: there is no such channel")
    return [_PLACES[key] for key in keys]


def _width(field: str) -> int:
    return int(np.prod(record_dtype(Telemetry)[field].shape, dtype=int))


def _is_vector(field: str) -> bool:
    return record_dtype(Telemetry)[field].shape == (2,)


def _channels(field: str) -> list[PlotChannel]:
    group, unit, width = TITLES[field], quantity(Telemetry, field).unit, _width(field)
    names = _ELEMENTS.get(field, _XY if width == 2 else ("",))
    keys = [f"{field}.{i}" for i in range(width)] if width > 1 else [field]
    found = [
        PlotChannel(key=key, group=group, name=name, unit=unit, field=field, index=i)
        for i, (key, name) in enumerate(zip(keys, names, strict=True))
    ]
    if _is_vector(field):
        norm = PlotChannel(key=f"{field}.norm", group=group, name="norm", unit=unit, field=field, index=None)
        found.append(norm)
    return found


CHANNELS: list[PlotChannel] = [channel for field in TITLES for channel in _channels(field)]
_PLACES = {channel.key: i for i, channel in enumerate(CHANNELS)}


def _plain(kind: str) -> tuple[type[np.generic], npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Fields that are stored as `kind`: the type, the places of their channels, and where in a row the numbers are."""
    places: list[int] = []
    found: list[int] = []
    size = np.dtype(kind).itemsize
    for field in (field for field in fields(Telemetry) if field.type == kind and field.name in TITLES):
        first, at, width = _PLACES[_channels(field.name)[0].key], field.offset // size, _width(field.name)
        places += range(first, first + width)
        found += range(at, at + width)
    return np.dtype(kind).type, np.array(places, np.intp), np.array(found, np.intp)


_PLAIN = [_plain(kind) for kind in ("float64", "float32", "int64")]
_VECTORS = [field for field in fields(Telemetry) if field.name in TITLES and _is_vector(field.name)]
_NORMS = np.array([_PLACES[f"{field.name}.norm"] for field in _VECTORS], np.intp)
_NORMED = np.array([field.offset // 8 for field in _VECTORS], np.intp)
