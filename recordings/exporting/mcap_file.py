"""MCAP for Foxglove and PlotJuggler: JSON messages, a topic for each group of signals, log time on the wall clock."""

import json
import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.writer import Writer

from recordings.exporting.table import Array, Column, Table

PIECE = 2_000
"""Rows of one topic that are written before the next topic's turn."""


class Topic(NamedTuple):
    """Columns that have their values at the same rows, and their channel in the file."""

    columns: list[Column]
    channel: int


def write_mcap(table: Table, target: Path) -> None:
    """A message per topic and row, with t [s] and its signals by name; what is not known (nan) is left out of it."""
    with target.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="tendril")
        topics = [_topic(writer, name, columns) for name, columns in _by_topic(table).items()]
        for first in range(0, len(table.t), PIECE):
            for topic in topics:
                for at, text in _messages(table, topic, first):
                    writer.add_message(topic.channel, at, text, at)
        writer.finish()  # type: ignore[no-untyped-call]


def _by_topic(table: Table) -> dict[str, list[Column]]:
    """What is not at every tick has a topic of its own."""
    found: dict[str, list[Column]] = defaultdict(list)
    for column in table.columns:
        found[f"/{column.signal.group if column.at is None else column.signal.field}"].append(column)
    return found


def _topic(writer: Writer, name: str, columns: list[Column]) -> Topic:
    units = {"t": "s"} | {column.signal.name: column.signal.unit for column in columns}
    properties = {signal: {"type": "number", "description": f"[{unit}]"} for signal, unit in units.items()}
    schema = {"type": "object", "title": name.removeprefix("/"), "properties": properties}
    id = writer.register_schema(f"tendril{name.replace('/', '.')}", "jsonschema", json.dumps(schema).encode())
    return Topic(columns, writer.register_channel(name, "json", id, {"units": json.dumps(units)}))


def _messages(table: Table, topic: Topic, first: int) -> Iterator[tuple[int, bytes]]:
    """Log times [Unix ns] and messages of PIECE rows from `first` on."""
    parts = [column.part(first, first + PIECE) for column in topic.columns]
    t_ns = _at(table.t_ns[first : first + PIECE], parts[0][1])
    t = (t_ns / 1e9).tolist()
    names = ["t", *(column.signal.name for column in topic.columns)]
    rows = zip(t, *(values.tolist() for values, _ in parts), strict=True)
    for at, row in zip(t_ns.tolist(), rows, strict=True):
        known = {name: value for name, value in zip(names, row, strict=True) if not math.isnan(value)}
        yield table.wall_ns + at, json.dumps(known).encode()


def _at(values: Array, rows: Array | None) -> Array:
    return values if rows is None else values[rows]
