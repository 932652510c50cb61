"""MCAP for Foxglove and PlotJuggler: JSON messages, a topic for each group of signals, log time on the wall clock.

Beside them the arm in Foxglove's own messages (foxglove.py).
"""

import json
from collections import defaultdict
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa

from controller.arrays import Values
from controller.schema.origin import CODES, Origin
from recordings.exporting import foxglove
from recordings.exporting.json_texts import Messages, Texts, digits, joined
from recordings.exporting.mcap_batches import BatchWriter
from recordings.exporting.table import Column, Table

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
    with target.open("wb") as file, ThreadPoolExecutor(1, "mcap") as beside:
        writer = BatchWriter(file, "tendril", beside)
        if origin is not None:
            words = {name: str(getattr(origin, name)) for name in ("version", "commit", "date", "command")}
            writer.add_metadata("origin", {**words, "json": origin.model_dump_json()})
        drawn = {topic: writer.add_channel(topic, foxglove.schema(topic)) for topic in foxglove.topics(first)}
        topics = [_topic(writer, name, first, columns) for name, columns in _by_topic(first).items()]
        marks = writer.add_channel("/bookmark", _bookmark_schema()) if first.bookmarks else 0
        for table in chain([first], later):
            for begin in range(0, len(table.t), PIECE):
                for topic in topics:
                    writer.add_messages(topic.channel, _messages(table, topic, begin))
                for name, messages in foxglove.messages(table, begin, min(begin + PIECE, len(table.t))).items():
                    writer.add_messages(drawn[name], messages)
            writer.add_messages(marks, _bookmarks(table))
        writer.finish()


def _by_topic(table: Table) -> dict[str, list[int]]:
    """What is not at every tick has a topic of its own."""
    found: dict[str, list[int]] = defaultdict(list)
    for place, column in enumerate(table.columns):
        found[f"/{column.signal.group if column.at is None else column.signal.field}"].append(place)
    return found


def _topic(writer: BatchWriter, name: str, table: Table, columns: list[int]) -> Topic:
    signals = [table.columns[place].signal for place in columns]
    units = {"t": "s"} | {signal.name: signal.unit for signal in signals}
    properties = {signal: {"type": "number", "description": _meaning(signal, unit)} for signal, unit in units.items()}
    schema = {"type": "object", "title": name.removeprefix("/"), "properties": properties}
    named = f"tendril{name.replace('/', '.')}", json.dumps(schema).encode()
    return Topic(columns, writer.add_channel(name, named, {"units": json.dumps(units)}))


def _meaning(signal: str, unit: str) -> str:
    """The unit, and what each value, or bit, of a code is called."""
    words = ", ".join(f"{value} {name}" for name, value in CODES.get(signal, {}).items())
    return f"[{unit}]" + (f" {words}" if words else "")


def _bookmark_schema() -> tuple[str, bytes]:
    """Name and JSON schema of the topic `/bookmark`: number and label at the row that was marked."""
    properties = {"t": {"type": "number"}, "text": {"type": "string"}}
    schema = {"type": "object", "title": "bookmark", "properties": properties}
    return "tendril.bookmark", json.dumps(schema).encode()


def _bookmarks(table: Table) -> Messages:
    marked = table.marked()
    texts = [json.dumps({"t": float(table.t[row]), "text": text}) for row, text in marked.items()]
    return Messages(table.t_ns[list(marked)] + table.wall_ns, pa.array(texts, pa.string()))


def _messages(table: Table, topic: Topic, begin: int) -> Messages:
    """Those of PIECE rows from `begin` on."""
    columns = [table.columns[place] for place in topic.columns]
    parts = [column.part(begin, begin + PIECE) for column in columns]
    t_ns = _at(table.t_ns[begin : begin + PIECE], parts[0][1])
    pairs = [_pairs(column, values) for column, (values, _) in zip(columns, parts, strict=True)]
    return Messages(t_ns + table.wall_ns, joined('{"t":', digits(t_ns / 1e9), *chain.from_iterable(pairs), "}"))


def _pairs(column: Column, values: Values) -> Sequence[str | Texts]:
    """`,"name":value` of each value (n,), "" where it is not known, as parts of a text."""
    name, texts = f',"{column.signal.name}":', digits(values)
    return [joined(name, texts).fill_null("")] if texts.null_count else [name, texts]


def _at(values: Values, rows: Values | None) -> Values:
    return values if rows is None else values[rows]
