"""MATLAB's .mat (version 5): one struct `tendril`."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from controller.errors import ParameterError
from controller.schema.origin import CODES, Origin
from recordings.exporting.table import Table, joined

BYTES_MAX = (1 << 31) - (1 << 20)
"""What the format can hold in one variable."""


def write_mat(tables: Iterable[Table], target: Path, origin: Origin | None) -> None:
    """`tendril.t`, a column vector per signal, `tendril.units`; what is not at every tick has its own times `FIELD_t`.

    `tendril.origin` is JSON, `tendril.codes.mode.HOLD` the number of that mode. Bookmarks are a cell array of text with
    times, too.

    ParameterError when it is more than the format can hold.
    """
    table = joined(_small(tables))
    fields: dict[str, Any] = {"t": table.t}
    for column in table.columns:
        if column.at is not None:
            fields[f"{column.signal.field}_t"] = table.t[column.at]
        fields[column.signal.name] = column.values
    if table.bookmarks:
        rows, texts = zip(*sorted(table.marked().items()), strict=True)
        fields["bookmark_t"], fields["bookmark"] = table.t[list(rows)], np.array(texts, object)
    fields["units"] = {"t": "s"} | {column.signal.name: column.signal.unit for column in table.columns}
    fields["started_unix_ns"] = table.wall_ns
    fields["codes"] = CODES
    if origin is not None:
        fields["origin"] = origin.model_dump_json()
    from scipy.io import savemat  # not for a start of the server

    savemat(target, {"tendril": fields}, oned_as="column", long_field_names=True)


def _small(tables: Iterable[Table]) -> Iterator[Table]:
    """`tables`, unless they become too large."""
    size = 0
    for table in tables:
        size += table.t.nbytes + sum(column.values.nbytes for column in table.columns)
        if size > BYTES_MAX:
            raise ParameterError(f"more than the {BYTES_MAX >> 20} MiB of a .mat file: choose signals or a window")
        yield table
