"""One recording into one file of the format that is asked for."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Literal

from controller.errors import ParameterError
from recordings.exporting.arrow import write_csv, write_parquet
from recordings.exporting.matlab import write_mat
from recordings.exporting.mcap_file import write_mcap
from recordings.exporting.table import Choice, RowReader, Table
from recordings.format import frames

Format = Literal["csv", "parquet", "mat", "mcap", "rrd"]
WRITERS: dict[Format, Callable[[Iterable[Table], Path], None]] = {
    "csv": write_csv,
    "parquet": write_parquet,
    "mat": write_mat,
    "mcap": write_mcap,
}


def export(source: Path, target: Path, kind: Format, choice: Choice) -> None:
    """Write what is chosen of the .rrd file `source` to `target`; of one that is being written, all that is there.

    ParameterError for a signal or window that it does not have; RecordingError when it cannot be read.
    """
    if kind == "rrd":
        require_whole(choice)
        frames.copy_whole(source, target)
    else:
        WRITERS[kind](RowReader(source).pieces(choice), target)


def require_whole(choice: Choice) -> None:
    """ParameterError unless everything is chosen: an .rrd file is given as it is."""
    if choice != Choice():
        raise ParameterError("format = rrd is the whole file as it is: signals, from and to are for the other formats")
