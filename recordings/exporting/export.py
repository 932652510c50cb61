"""One recording into one file of the format that is asked for."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from controller.errors import ParameterError, RecordingError
from controller.schema.origin import Origin, hashes, origin, origin_of_rig
from controller.system.progress import ProgressCallback, no_progress
from recordings.exporting.table import Choice, RowReader, Table
from recordings.format import frames
from recordings.importing.tip import IMPORT_RIG
from recordings.read.reader import read_about

Format = Literal["csv", "parquet", "mat", "mcap", "rrd"]
Writer = Callable[[Iterable[Table], Path, Origin | None], None]


@dataclass(frozen=True)
class By:
    """Who exports."""

    command: str = ""
    """As it was typed; "" for a server."""
    comments: bool = False
    """A CSV file begins with its origin as lines with #, which not everything that reads CSV leaves out."""


def export(
    source: Path, target: Path, kind: Format, choice: Choice, by: By = By(), told: ProgressCallback = no_progress
) -> None:
    """Write what is chosen of the .rrd file `source` to `target`; of one that is being written, all that is there.

    `told` is told the share of the rows that were read.

    ParameterError for a signal or window that it does not have; RecordingError when it cannot be read.
    """
    if kind == "rrd":
        require_whole(choice)
        frames.copy_whole(source, target)
    else:
        wanted = kind != "csv" or by.comments
        pieces = _while_wanted(RowReader(source).pieces(choice, told), target.parent)
        _writer(kind)(pieces, target, origin_of(source, by.command) if wanted else None)


def export_for_viewer(source: Path, target: Path, dark: bool) -> None:
    """Write the recording as rerun's viewer shows it beside our page (for_rerun.py); RecordingError as `export`."""
    from recordings.exporting.for_rerun import for_rerun  # as in _writer: a server only passes the order on

    for_rerun(source, target, dark)


def origin_of(source: Path, command: str = "") -> Origin:
    """That of a file which is made of the recording `source`; RecordingError when that cannot be read."""
    info, settings = read_about(source)
    by = {"files": hashes([source]), "recorded_by": info.program}
    if info.rig == IMPORT_RIG:  # nothing is known of what it was
        return origin(command, **by)
    return origin_of_rig(info.parameters, command, info.twin, settings=settings, **by)


def _while_wanted(pieces: Iterable[Table], folder: Path) -> Iterator[Table]:
    """The pieces, until someone removes the `folder` that the file is written into: no one wants it any more."""
    for piece in pieces:
        if not folder.is_dir():
            raise RecordingError(f"{folder} is gone: the export was cancelled")
        yield piece


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
