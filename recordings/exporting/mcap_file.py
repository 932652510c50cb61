"""MCAP for Foxglove and PlotJuggler: JSON messages, a topic for each group of signals, log time on the wall clock.

Beside them the arm in Foxglove's own messages (foxglove.py).
"""

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from mcap.writer import Writer

from controller.arrays import Values
from controller.schema.origin import CODES, Origin
from recordings.exporting import foxglove
from recordings.exporting.table import Column, Table

CHUNK_BYTES = 4 << 20
"""Of messages that are compressed together: a player reads so much at once."""
PIECE = 2_000
"""Rows of one topic that are written before the next topic's turn."""


class Topic(NamedTuple):
    """Columns, by their place in the table, that have their values at the same rows, and their channel in the file."""

    columns: list[int]
    channel: int


def write_mcap(tables: Iterable[Table], target: Path, origin: Origin | None) -> None:
    """A message per topic and row, with t [s] and its signals by name; what is not known (nan) is left out of it.

    `origin` is a metadata record of this name. Bookmarks are a topic of their own.
    """
    later = iter(tables)
    first = next(later)
    with target.open("wb") as file:
        writer = Writer(file, chunk_size=CHUNK_BYTES)
        writer.start(profile="", library="tendril")
        if origin is not None:
            words = {name: str(getattr(origin, name)) for name in ("version", "commit", "date", "command")}
            writer.add_metadata("origin", {**words, "json": origin.model_dump_json()})
        drawn = {topic: _drawn(writer, topic) for topic in foxglove.topics(first)}
        topics = [_topic(writer, name, first, columns) for name, columns in _by_topic(first).items()]
        marks = _bookmarks(writer) if first.bookmarks else 0
        for table in chain([first], later):
            for begin in range(0, len(table.t), PIECE):
                for topic in topics:
                    for at, text in _messages(table, topic, begin):
                        writer.add_message(topic.channel, at, text, at)
                for message in foxglove.messages(table, begin, min(begin + PIECE, len(table.t))):
                    writer.add_message(drawn[message.topic], message.at, message.text, message.at)
            for row, mark in table.marked().items():
                at = int(table.t_ns[row]) + table.wall_ns
                writer.add_message(marks, at, json.dumps({"t": float(table.t[row]), "text": mark}).encode(), at)
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
    properties = {signal: {"type": "number", "description": _meaning(signal, unit)} for signal, unit in units.items()}
    schema = {"type": "object", "title": name.removeprefix("/"), "properties": properties}
    id = writer.register_schema(f"tendril{name.replace('/', '.')}", "jsonschema", json.dumps(schema).encode())
    return Topic(columns, writer.register_channel(name, "json", id, {"units": json.dumps(units)}))


def _meaning(signal: str, unit: str) -> str:
    """The unit, and what each value, or bit, of a code is called."""
    words = ", ".join(f"{value} {name}" for name, value in CODES.get(signal, {}).items())
    return f"[{unit}]" + (f" {words}" if words else "")


def _drawn(writer: Writer, topic: str) -> int:
    """The channel of one of Foxglove's own messages."""
    name, published = foxglove.schema(topic)
    return writer.register_channel(topic, "json", writer.register_schema(name, "jsonschema", published))


def _bookmarks(writer: Writer) -> int:
    """The channel of the topic `/bookmark`: number and label at the row that was marked."""
    schema = {
        "type": "object",
        "title": "bookmark",
        "properties": {"t": {"type": "number"}, "text": {"type": "string"}},
    }
    id = writer.register_schema("tendril.bookmark", "jsonschema", json.dumps(schema).encode())
    return writer.register_channel("/bookmark", "json", id)


def _messages(table: Table, topic: Topic, begin: int) -> Iterator[tuple[int, bytes]]:
    """Log times [Unix ns] and messages of PIECE rows from `begin` on."""
    columns = [table.columns[place] for place in topic.columns]
    parts = [column.part(begin, begin + PIECE) for column in columns]
    t_ns = _at(table.t_ns[begin : begin + PIECE], parts[0][1])
    pairs = [_pairs(column, values) for column, (values, _) in zip(columns, parts, strict=True)]
    texts = pc.binary_join_element_wise('{"t":', _digits(t_ns / 1e9), *pairs, "}", "")
    yield from zip((t_ns + table.wall_ns).tolist(), texts.cast(pa.binary()).to_pylist(), strict=True)


def _pairs(column: Column, values: Values) -> Any:
    """`,"name":value` of each value (n,), "" where it is not known: Arrow's strings are made many at once."""
    pairs = pc.binary_join_element_wise(f',"{column.signal.name}":', _digits(values), "")
    known = np.isfinite(values)
    return pairs if known.all() else pc.if_else(pa.array(known), pairs, "")


def _digits(values: Values) -> Any:
    """Numbers as text that reads back exactly; float32 with the digits of the same float64."""
    wide = values.astype(np.float64) if values.dtype.kind == "f" else values
    return pa.array(wide, from_pandas=False).cast(pa.string())


def _at(values: Values, rows: Values | None) -> Values:
    return values if rows is None else values[rows]
