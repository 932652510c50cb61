"""MATLAB's .mat (version 5): one struct `tendril`."""

from pathlib import Path
from typing import Any

from scipy.io import savemat

from controller.errors import ParameterError
from recordings.exporting.table import Table

BYTES_MAX = (1 << 31) - (1 << 20)
"""What the format can hold in one variable."""


def write_mat(table: Table, target: Path) -> None:
    """`tendril.t`, a column vector per signal, `tendril.units`; what is not at every tick has its own times `FIELD_t`.

    ParameterError when it is more than the format can hold.
    """
    size = table.t.nbytes + sum(column.values.nbytes for column in table.columns)
    if size > BYTES_MAX:
        raise ParameterError(
            f"{size >> 20} MiB are more than the {BYTES_MAX >> 20} MiB of a .mat file: choose signals or a window"
        )
    fields: dict[str, Any] = {"t": table.t}
    for column in table.columns:
        if column.at is not None:
            fields[f"{column.signal.field}_t"] = table.t[column.at]
        fields[column.signal.name] = column.values
    fields["units"] = {"t": "s"} | {column.signal.name: column.signal.unit for column in table.columns}
    fields["started_unix_ns"] = table.wall_ns
    savemat(target, {"tendril": fields}, oned_as="column", long_field_names=True)
