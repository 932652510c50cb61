"""MCAP for Foxglove and PlotJuggler: JSON messages, a topic for each group of signals, log time on the wall clock."""

import json
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from mcap.writer import Writer

from recordings.chunks import Array
from recordings.exporting.table import Table

PIECE = 2_000
"""Rows of one topic that are written before the next topic's turn."""


class Topic(NamedTuple):
    """Columns, by their place in the table, that have their values at the same rows, and their channel in the file."""

    columns: list[int]
    channel: int


def write_mcap(tables: Iterable[Table], target: Path) -> None:
    """A message per topic and row, with t [s] and its signals by name; what is not known (nan) is left out of it."""
    later = iter(tables)
    first = next(later)
    with target.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="", library="tendril")
        topics = [_topic(writer, name, first, columns) for name, columns in _by_topic(first).items()]
        for table in chain([first], later):
            for begin in range(0, len(table.t), PIECE):
                for topic in topics:
                    for at, text in _messages(table, topic, begin):
                        writer.add_message(topic.channel, at, text, at)
        writer.finish()  # type: ignore[no-untyped-call]


def _by_topic(table: Table) -> dict[str, list[int]]:
    """What is not at every tick has a topic of its own."""
    found: dict[str, list[int]] = defaultdict(list)
    for place, column in enumerate(table.columns):
        found[f"/{column.signal.group if column.at is None else column.signal.field}"].append(place)
    return found


def _topic(writer: Writer, name: str, table: Table, columns: list[int]) -> Topic:
    signals = [table.columns[place].signal for place in columns]
    units = {"t": "s"} | {signal.name: signal.unit for signal in signals}
    properties = {signal: {"type": "number", "description": f"[{unit}]"} for signal, unit in units.items()}
    schema = {"type": "object", "title": name.removeprefix("/"), "properties": properties}
    id = writer.register_schema(f"tendril{name.replace('/', '.')}", "jsonschema", json.dumps(schema).encode())
    return Topic(columns, writer.register_channel(name, "json", id, {"units": json.dumps(units)}))


def _messages(table: Table, topic: Topic, begin: int) -> Iterator[tuple[int, bytes]]:
    """Log times [Unix ns] and messages of PIECE rows from `begin` on."""
    columns = [table.columns[place] for place in topic.columns]
    parts = [column.part(begin, begin + PIECE) for column in columns]
    t_ns = _at(table.t_ns[begin : begin + PIECE], parts[0][1])
    names = ["t", *(column.signal.name for column in columns)]
    rows = zip((t_ns / 1e9).tolist(), *(values.tolist() for values, _ in parts), strict=True)
    for at, row in zip(t_ns.tolist(), rows, strict=True):
        known = {name: value for name, value in zip(names, row, strict=True) if not math.isnan(value)}
        yield table.wall_ns + at, json.dumps(known).encode()


def _at(values: Array, rows: Array | None) -> Array:
    return values if rows is None else values[rows]
