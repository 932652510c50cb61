"""CSV and Parquet, piece by piece through Arrow: the numbers are exact, those that are not there are blank or null."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from recordings.exporting.table import Column, Table

PIECE = 50_000
"""Rows that are converted at once."""
Batch = Any
"""A pyarrow RecordBatch (pyarrow has no types)."""


def write_csv(table: Table, target: Path) -> None:
    """One header line with `name [unit]`, t first; every number with all its digits."""
    schema = _schema(table)
    options = pa.csv.WriteOptions(include_header=False, quoting_style="none")
    with target.open("wb") as file:
        file.write((",".join(map(_title, schema)) + "\n").encode())
        with pa.csv.CSVWriter(file, schema, write_options=options) as writer:
            for batch in _batches(table, schema):
                writer.write_batch(batch)


def write_parquet(table: Table, target: Path) -> None:
    """One row group a piece; the unit of a column is in the metadata of its field."""
    schema = _schema(table)
    with pa.parquet.ParquetWriter(target, schema, compression="zstd") as writer:
        for batch in _batches(table, schema):
            writer.write_batch(batch)


def _schema(table: Table) -> Any:
    fields = [pa.field("t", pa.float64(), metadata={"unit": "s"})]
    for column in table.columns:
        kind = pa.from_numpy_dtype(column.values.dtype)
        fields.append(pa.field(column.signal.name, kind, metadata={"unit": column.signal.unit}))
    return pa.schema(fields, metadata={"started_unix_ns": str(table.wall_ns)})


def _title(field: Any) -> str:
    unit = field.metadata[b"unit"].decode()
    return field.name if unit == "1" else f"{field.name} [{unit}]"


def _batches(table: Table, schema: Any) -> Iterator[Batch]:
    for first in range(0, len(table.t), PIECE):
        t = table.t[first : first + PIECE]
        columns = [pa.array(t), *(_array(column, first, len(t)) for column in table.columns)]
        yield pa.record_batch(columns, schema=schema)


def _array(column: Column, first: int, count: int) -> Any:
    """The column over `count` rows from `first` on, null where it has no value; nan stays nan."""
    values, at = column.part(first, first + count)
    if at is None:
        return pa.array(values, from_pandas=False)
    whole, blank = np.zeros(count, values.dtype), np.ones(count, bool)
    whole[at], blank[at] = values, False
    return pa.array(whole, mask=blank, from_pandas=False)
