"""One recording into one file of the format that is asked for."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Literal, get_args

from controller.errors import ParameterError
from controller.system.progress import Told, untold
from recordings.exporting.table import Choice, RowReader, Table
from recordings.format import frames

Format = Literal["csv", "parquet", "mat", "mcap", "rrd"]
Writer = Callable[[Iterable[Table], Path], None]


def export(source: Path, target: Path, kind: Format, choice: Choice, told: Told = untold) -> None:
    """Write what is chosen of the .rrd file `source` to `target`; of one that is being written, all that is there.

    `told` is told the share of the rows that were read.

    ParameterError for a signal or window that it does not have; RecordingError when it cannot be read.
    """
    if kind == "rrd":
        require_whole(choice)
        frames.copy_whole(source, target)
    else:
        _writer(kind)(RowReader(source).pieces(choice, told), target)


def require_whole(choice: Choice) -> None:
    """ParameterError unless everything is chosen: an .rrd file is given as it is."""
    if choice != Choice():
        raise ParameterError("format = rrd is the whole file as it is: signals, from and to are for the other formats")


def warm_up() -> None:
    """Import what writes every format: who asks for the first one does not wait for that."""
    for kind in get_args(Format):
        if kind != "rrd":
            _writer(kind)


def _writer(kind: Format) -> Writer:
    """Each brings libraries of its own, so it is imported when it is asked for: a server only passes the order on."""
    match kind:
        case "csv":
            from recordings.exporting.arrow import write_csv

            return write_csv
        case "parquet":
            from recordings.exporting.arrow import write_parquet

            return write_parquet
        case "mat":
            from recordings.exporting.matlab import write_mat

            return write_mat
        case "mcap":
            from recordings.exporting.mcap_file import write_mcap

            return write_mcap
        case "rrd":
            raise AssertionError("an .rrd file is copied")
