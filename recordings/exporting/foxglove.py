"""The arm as Foxglove's own messages, so that its 3D panel shows it: the schemas are those that Foxglove publishes."""

import json
import math
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from controller.arrays import Values
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.palette import MEASURED, OBSERVER, REFERENCE, TWIN
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
NOW, PLACE = '"NOW"', '"PLACE"'
"""What is put into the text of each message, most of which is the same every time."""
KINDS = "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"


class Message(NamedTuple):
    """One message: its topic, its time [Unix ns], its JSON."""

    topic: str
    at: int
    text: bytes


@cache
def schema(topic: str) -> tuple[str, bytes]:
    """Name and JSON schema of a topic, as Foxglove publishes them."""
    name = SCHEMAS[topic]
    return f"foxglove.{name}", files("recordings.exporting").joinpath(f"schemas/{name}.json").read_bytes()


def topics(table: Table) -> tuple[str, ...]:
    """Those for which `table` has whole backbones and points."""
    there = {SCENE: any(_of(table, field) for field in BACKBONES), TIP: bool(_of(table, "backbone"))}
    return tuple(topic for topic in SCHEMAS if there.get(topic, there[TIP] and bool(_of(table, "p_ref"))))


def messages(table: Table, begin: int, end: int) -> Iterator[Message]:
    """Those of the table's rows from `begin` up to `end`: one of each topic at every row that has a backbone."""
    wanted = topics(table)
    if not wanted:
        return
    rows = _rows(_of(table, "backbone") or _of(table, "twin_backbone"), begin, end)
    arms = {field: _values(_of(table, field), rows) for field in BACKBONES if _of(table, field)}
    points = {field: _values(_of(table, field), rows)[:, 0] for field in POINTS if _of(table, field)}
    for place, at in enumerate((table.t_ns[rows] + table.wall_ns).tolist()):
        found = {SCENE: _scene({field: arm[place] for field, arm in (arms | points).items()})}
        if TIP in wanted:
            found[TIP] = _pose(arms["backbone"][place, -1], _direction(arms["backbone"][place]))
        if WANTED in wanted:
            found[WANTED] = _pose(points["p_ref"][place], REST)
        now = json.dumps({"sec": at // 10**9, "nsec": at % 10**9})
        yield from (Message(topic, at, text.replace(NOW, now).encode()) for topic, text in found.items() if text)


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
    out = np.full((len(rows), len(columns)), np.nan)
    for place, column in enumerate(columns):
        if column.at is None:
            out[:, place] = column.values[rows]
        elif len(column.at):
            near = np.searchsorted(column.at, rows).clip(max=len(column.at) - 1)
            out[:, place] = np.where(column.at[near] == rows, column.values[near], np.nan)
    return out.reshape(len(rows), -1, 2)


def _scene(found: dict[str, Values]) -> str:
    """All of which a point (2,) or backbone (n, 2) [m] is known."""
    entities = [
        _entity(field).replace(PLACE, _vectors(values) if values.ndim > 1 else _vectors(values[np.newaxis])[1:-1])
        for field, values in found.items()
        if np.isfinite(values).all()
    ]
    return f'{{"deletions": [], "entities": [{", ".join(entities)}]}}'


@cache
def _entity(field: str) -> str:
    """What is drawn for a field, but for NOW and PLACE; it stays until the next one of the same name."""
    if field in BACKBONES:
        name, colour, width = BACKBONES[field]
        look = {"type": 0, "thickness": width, "scale_invariant": True, "color": _colour(colour), "colors": []}
        drawn = {"lines": [look | {"pose": _at(ORIGIN), "points": "PLACE", "indices": []}]}
    else:
        name, colour = POINTS[field]
        size = {"x": SPHERE, "y": SPHERE, "z": SPHERE}
        drawn = {"spheres": [{"pose": _at("PLACE"), "size": size, "color": _colour(colour)}]}
    about = {"timestamp": "NOW", "frame_id": FRAME, "id": name, "lifetime": {"sec": 0, "nsec": 0}}
    return json.dumps({**about, "frame_locked": True, "metadata": [], **{kind: [] for kind in KINDS}, **drawn})


def _pose(point: Values, orientation: dict[str, float]) -> str:
    """Nothing where the point (2,) [m] is not known."""
    if not np.isfinite(point).all():
        return ""
    text = json.dumps({"timestamp": "NOW", "frame_id": FRAME, "pose": _at("PLACE", orientation)})
    return text.replace(PLACE, _vectors(point[np.newaxis])[1:-1])


def _direction(arm: Values) -> dict[str, float]:
    """Where the last piece of a backbone (n, 2) points, as a turn about z."""
    dx, dy = (arm[-1] - arm[-2]).tolist()
    half = 0.5 * math.atan2(dy, dx)
    return {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}


def _at(position: object, orientation: dict[str, float] = REST) -> dict[str, object]:
    return {"position": position, "orientation": orientation}


def _vectors(points: Values) -> str:
    """Points (n, 2) [m] as a JSON list, to 1 um."""
    return "[" + ", ".join(f'{{"x": {x:.6f}, "y": {y:.6f}, "z": 0.0}}' for x, y in points.tolist()) + "]"


def _colour(colour: int) -> dict[str, float]:
    return {name: (colour >> shift & 0xFF) / 255 for name, shift in (("r", 16), ("g", 8), ("b", 0))} | {"a": 1.0}
