"""The signals that can be plotted: every number of a telemetry row but its time, and the norms of plane vectors."""

import numpy as np
import numpy.typing as npt

from controller.arrays import Rows
from controller.errors import ParameterError
from controller.schema.layout import fields, numbers, quantity, record_dtype
from controller.schema.messages import Telemetry
from controller.schema.states import LIVE
from controller.schema.titles import TITLES, elements
from server.rig.messages import PlotChannel


class UnknownChannel(ParameterError):
    """There is no channel of this key."""


def extract(rows: Rows) -> npt.NDArray[np.float32]:
    """Values of all channels, (n, channels), of n telemetry rows; a norm is that of each row, nan where one is.

    There is no error where no reference rules.
    """
    out = np.empty((len(rows), len(CHANNELS)), np.float32)
    for kind, places, found in _PLAIN:
        out[:, places] = numbers(rows, kind)[:, found]
    plane = numbers(rows, np.float64)
    out[:, _NORMS] = np.hypot(plane[:, _NORMED], plane[:, _NORMED + 1])
    out[np.ix_(~np.isin(rows["mode"], LIVE), _OF_ERROR)] = np.nan
    return out


def column(rows: Rows, channel: PlotChannel) -> npt.NDArray[np.float64]:
    """Values (n,) of one channel of n telemetry rows, as exact as they are there; no error without a reference."""
    values = rows[channel.field].reshape(len(rows), _width(channel.field)).astype(np.float64)
    if channel.field == "error":
        values[~np.isin(rows["mode"], LIVE)] = np.nan
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
    keys = [f"{field}.{i}" for i in range(width)] if width > 1 else [field]
    found = [
        PlotChannel(key=key, group=group, name=name, unit=unit, field=field, index=i)
        for i, (key, name) in enumerate(zip(keys, elements(field), strict=True))
    ]
    if _is_vector(field):
        norm = PlotChannel(key=f"{field}.norm", group=group, name="norm", unit=unit, field=field, index=None)
        found.append(norm)
    return found


PLOTTED = tuple(field for field in TITLES if field != "t_ns")
"""In the order of the page's menu."""
CHANNELS: list[PlotChannel] = [channel for field in PLOTTED for channel in _channels(field)]
_PLACES = {channel.key: i for i, channel in enumerate(CHANNELS)}


def _plain(kind: str) -> tuple[type[np.generic], npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Fields that are stored as `kind`: the type, the places of their channels, and where in a row the numbers are."""
    places: list[int] = []
    found: list[int] = []
    size = np.dtype(kind).itemsize
    for field in (field for field in fields(Telemetry) if field.type == kind and field.name in PLOTTED):
        first, at, width = _PLACES[_channels(field.name)[0].key], field.offset // size, _width(field.name)
        places += range(first, first + width)
        found += range(at, at + width)
    return np.dtype(kind).type, np.array(places, np.intp), np.array(found, np.intp)


_PLAIN = [_plain(kind) for kind in ("float64", "float32", "int64")]
_VECTORS = [field for field in fields(Telemetry) if field.name in PLOTTED and _is_vector(field.name)]
_NORMS = np.array([_PLACES[f"{field.name}.norm"] for field in _VECTORS], np.intp)
_OF_ERROR = np.array([place for key, place in _PLACES.items() if key.startswith("error.")], np.intp)
_NORMED = np.array([field.offset // 8 for field in _VECTORS], np.intp)
