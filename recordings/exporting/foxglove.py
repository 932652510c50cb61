"""The arm as Foxglove's own messages, so that its 3D panel shows it: the schemas are those that Foxglove publishes."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from controller.arrays import Values
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.palette import MEASURED, OBSERVER, REFERENCE, TWIN
from recordings.exporting.json_texts import Messages, Texts, digits, joined
from recordings.exporting.table import Column, Table

FRAME = "base"
"""The frame of the README: the base at the origin, at rest along +x, z out of the plane."""
SCENE, TIP, WANTED = "/arm", "/pose/tip", "/pose/reference"
SCHEMAS = {SCENE: "SceneUpdate", TIP: "PoseInFrame", WANTED: "PoseInFrame"}
"""Each topic's schema."""
BACKBONES = {"backbone": ("observer", OBSERVER, 4.0), "twin_backbone": ("twin", TWIN, 2.0)}
"""Name, colour and width [px] of what is drawn for a field."""
POINTS = {"p_ref": ("reference", REFERENCE), "p_meas": ("measured tip", MEASURED)}
SPHERE = 0.006
"""Diameter of a point [m]."""
ORIGIN, REST = {"x": 0.0, "y": 0.0, "z": 0.0}, {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
"""Position and orientation of the frame itself."""
BLANK = re.compile('"(NOW|PLACE|TURN)"')
"""What is put into the text of each message, most of which is the same every time."""
KINDS = "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"


@cache
def schema(topic: str) -> tuple[str, bytes]:
    """Name and JSON schema of a topic, as Foxglove publishes them."""
    name = SCHEMAS[topic]
    return f"foxglove.{name}", files("recordings.exporting").joinpath(f"schemas/{name}.json").read_bytes()


def topics(table: Table) -> tuple[str, ...]:
    """Those for which `table` has whole backbones and points."""
    there = {SCENE: any(_of(table, field) for field in BACKBONES), TIP: bool(_of(table, "backbone"))}
    return tuple(topic for topic in SCHEMAS if there.get(topic, there[TIP] and bool(_of(table, "p_ref"))))


def messages(table: Table, begin: int, end: int) -> dict[str, Messages]:
    """Those of the table's rows from `begin` up to `end`: one of each topic at every row that has a backbone."""
    wanted = topics(table)
    if not wanted:
        return {}
    rows = _rows(_of(table, "backbone") or _of(table, "twin_backbone"), begin, end)
    at = table.t_ns[rows] + table.wall_ns
    found = {field: _values(_of(table, field), rows) for field in (*BACKBONES, *POINTS) if _of(table, field)}
    now = joined('{"sec": ', digits(at // 10**9), ', "nsec": ', digits(at % 10**9), "}")
    texts = {SCENE: _scene(found, now)}
    if TIP in wanted:
        texts[TIP] = _pose(now, found["backbone"][:, -1:], _direction(found["backbone"]))
    if WANTED in wanted:
        texts[WANTED] = _pose(now, found["p_ref"], json.dumps(REST))
    return {topic: _known(at, made) for topic, made in texts.items()}


def _known(at: Values, texts: Texts) -> Messages:
    """Those of which nothing is missing."""
    return Messages(at[texts.is_valid().to_numpy(zero_copy_only=False)], texts.drop_null())


def _of(table: Table, field: str) -> Sequence[Column]:
    """All columns of `field`, x and y in turn; none where one is missing."""
    found = [column for column in table.columns if column.signal.field == field]
    every = record_dtype(Telemetry)[field].shape
    return sorted(found, key=lambda column: column.signal.index) if len(found) == math.prod(every) else []


def _rows(columns: Sequence[Column], begin: int, end: int) -> Values:
    """Rows of the table (k,) at which `columns` have values."""
    at = columns[0].at
    return np.arange(begin, end) if at is None else at[(at >= begin) & (at < end)]


def _values(columns: Sequence[Column], rows: Values) -> Values:
    """Points (k, n, 2) [m] at `rows` (k,) of the table; nan where there are none."""
    at, out = columns[0].at, np.full((len(rows), len(columns)), np.nan)
    there = np.ones(len(rows), bool) if at is None else np.isin(rows, at)
    near = rows if at is None else np.searchsorted(at, rows[there])
    out[there] = np.column_stack([column.values[near] for column in columns])
    return out.reshape(len(rows), len(columns) // 2, 2)


def _scene(found: Mapping[str, Values], now: Texts) -> Texts:
    """At each row all of which the point (k, 1, 2) or backbone (k, n, 2) [m] is known there."""
    first, *more = [_filled(_entity(field), {"NOW": now, "PLACE": _vectors(points)}) for field, points in found.items()]
    none = pc.is_null(pc.coalesce(first, *more))
    first = pc.if_else(none, "", first)  # Arrow leaves out a row of which it skips everything
    known = pc.binary_join_element_wise(first, *more, ", ", null_handling="skip")
    return joined('{"deletions": [], "entities": [', known, "]}")


@cache
def _entity(field: str) -> str:
    """What is drawn for a field, but for its blanks; it stays until the next one of the same name."""
    if field in BACKBONES:
        name, colour, width = BACKBONES[field]
        look = {"type": 0, "thickness": width, "scale_invariant": True, "color": _colour(colour), "colors": []}
        drawn = {"lines": [look | {"pose": _at(ORIGIN), "points": ["PLACE"], "indices": []}]}
    else:
        name, colour = POINTS[field]
        size = {"x": SPHERE, "y": SPHERE, "z": SPHERE}
        drawn = {"spheres": [{"pose": _at("PLACE"), "size": size, "color": _colour(colour)}]}
    about = {"timestamp": "NOW", "frame_id": FRAME, "id": name, "lifetime": {"sec": 0, "nsec": 0}}
    return json.dumps({**about, "frame_locked": True, "metadata": [], **{kind: [] for kind in KINDS}, **drawn})


def _pose(now: Texts, points: Values, turn: str | Texts) -> Texts:
    """Null where the point (k, 1, 2) is not known."""
    text = json.dumps({"timestamp": "NOW", "frame_id": FRAME, "pose": _at("PLACE", "TURN")})
    return _filled(text, {"NOW": now, "PLACE": _vectors(points), "TURN": turn})


def _direction(arms: Values) -> Texts:
    """Where the last piece of each backbone (k, n, 2) points, as a turn about z."""
    dx, dy = (arms[:, -1] - arms[:, -2]).T
    half = 0.5 * np.arctan2(dy, dx)
    return joined('{"x": 0.0, "y": 0.0, "z": ', digits(np.sin(half)), ', "w": ', digits(np.cos(half)), "}")


def _at(position: object, orientation: object = REST) -> dict[str, object]:
    return {"position": position, "orientation": orientation}


def _filled(text: str, values: Mapping[str, str | Texts]) -> Texts:
    """A text with its blanks filled in at each row."""
    return joined(*(values.get(part, part) for part in BLANK.split(text)))


def _vectors(points: Values) -> Texts:
    """Points (k, n, 2) [m] to 1 um, each row's as JSON with commas between; null where one is not known."""
    count = points.shape[1]
    x, y = (digits(np.round(points[..., axis].ravel(), 6)) for axis in (0, 1))
    every = joined('{"x": ', x, ', "y": ', y, ', "z": 0.0}')
    starts = pa.array(np.arange(0, len(every) + 1, count, dtype=np.int32))
    return pc.binary_join(pa.ListArray.from_arrays(starts, every), ", ")


def _colour(colour: int) -> dict[str, float]:
    return {name: (colour >> shift & 0xFF) / 255 for name, shift in (("r", 16), ("g", 8), ("b", 0))} | {"a": 1.0}
