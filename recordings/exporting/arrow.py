"""CSV and Parquet, piece by piece through Arrow: the numbers are exact, those that are not there are blank or null."""

import json
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from controller.schema.origin import CODES, Origin, comment_lines
from recordings.exporting.table import Column, Table

BOOKMARK = "bookmark"
"""The last column, of a recording that has any."""
Batch = Any
"""A pyarrow RecordBatch (pyarrow has no types)."""


def write_csv(tables: Iterable[Table], target: Path, origin: Origin | None = None) -> None:
    """One header line with `name [unit]`, t first; every number with all its digits, a bookmark's text in quotes.

    Before it lines of `origin`.
    """
    schema, tables = _with_schema(tables)
    options = pa.csv.WriteOptions(include_header=False, quoting_style="needed")
    with target.open("wb") as file:
        file.write(comment_lines(origin).encode())
        file.write((",".join(map(_title, schema)) + "\n").encode())
        with pa.csv.CSVWriter(file, schema, write_options=options) as writer:
            for table in tables:
                writer.write_batch(_batch(table, schema))


def write_parquet(tables: Iterable[Table], target: Path, origin: Origin | None = None) -> None:
    """One row group a table. A field's metadata has its unit and the names of its codes, the file's has `origin`."""
    schema, tables = _with_schema(tables)
    if origin is not None:
        schema = schema.with_metadata(schema.metadata | {"origin": origin.model_dump_json()})
    with pa.parquet.ParquetWriter(target, schema, compression="zstd") as writer:
        for table in tables:
            writer.write_batch(_batch(table, schema))


def _with_schema(tables: Iterable[Table]) -> tuple[Any, Iterable[Table]]:
    """The schema that all of `tables` have in common, and they themselves."""
    later = iter(tables)
    first = next(later)
    return _schema(first), chain([first], later)


def _schema(table: Table) -> Any:
    fields = [pa.field("t", pa.float64(), metadata={"unit": "s"})]
    for column in table.columns:
        kind = pa.from_numpy_dtype(column.values.dtype)
        words = CODES.get(column.signal.name)
        about = {"unit": column.signal.unit} | ({"codes": json.dumps(words)} if words else {})
        fields.append(pa.field(column.signal.name, kind, metadata=about))
    if table.bookmarks:
        fields.append(pa.field(BOOKMARK, pa.string(), metadata={"unit": "1"}))
    return pa.schema(fields, metadata={"started_unix_ns": str(table.wall_ns)})


def _title(field: Any) -> str:
    unit = field.metadata[b"unit"].decode()
    return field.name if unit == "1" else f"{field.name} [{unit}]"


def _batch(table: Table, schema: Any) -> Batch:
    arrays = [pa.array(table.t), *(_array(one, len(table.t)) for one in table.columns)]
    if table.bookmarks:
        texts = table.marked()
        arrays.append(pa.array([texts.get(row) for row in range(len(table.t))], pa.string()))
    return pa.record_batch(arrays, schema=schema)


def _array(column: Column, count: int) -> Any:
    """The column over the table's `count` rows, null where it has no value; nan stays nan."""
    if column.at is None:
        return pa.array(column.values, from_pandas=False)
    whole, blank = np.zeros(count, column.values.dtype), np.ones(count, bool)
    whole[column.at], blank[column.at] = column.values, False
    return pa.array(whole, mask=blank, from_pandas=False)
