"""A measured path of the tip (time, x, y) as a recording like any other, of which nothing else is known."""

from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from controller.arrays import Rows
from controller.errors import DataError, RecordingError
from controller.reference.path_file import Samples, samples_in
from controller.schema.layout import layout_hash, record_dtype
from controller.schema.messages import Command, RigInfo, Telemetry
from controller.schema.parameters import RigParameters, Settings
from controller.system.origin import commit, our_version
from controller.text.lines import sent_lines
from recordings.format import sidecar
from recordings.format.about import About
from recordings.format.messages import Recording
from recordings.write.session import check_room

IMPORT_RIG = "import"
"""The rig that an imported recording names."""
SENT = "the file"
"""What errors call a file that was sent rather than stored."""


def import_text(folder: Path, name: str, text: bytes, units: Mapping[str, str]) -> tuple[Recording, tuple[str, ...]]:
    """As `read_samples` and `import_tip`, and what the file left open; DataError names line, column and value."""
    samples = samples_in(sent_lines(text, SENT), Path(SENT), units)
    return import_tip(folder, name, samples), samples.notes


def import_tip(folder: Path, name: str, samples: Samples) -> Recording:
    """`samples` as a new recording in `folder`, started now.

    DataError for times that are one to the nanosecond; RecordingError when the disk is nearly full or takes no more.
    """
    rows = tip_rows(samples)
    try:
        folder.mkdir(sidecar.FOLDER_MODE, parents=True, exist_ok=True)
        check_room(folder)
        return _imported(folder, name, rows)
    except OSError as error:
        raise RecordingError(f"nothing can be written into {folder}: {error.strerror}") from error


def _imported(folder: Path, name: str, rows: Rows) -> Recording:
    from recordings.write.rrd import write_whole  # a server only passes the order on

    started = datetime.now(UTC)
    id, lock = sidecar.claim(folder, name, started)
    path = sidecar.rrd_path(folder, id)
    with lock:
        try:
            write_whole(path, About(id, name, _info(started), Settings()), rows)
        except BaseException:
            path.unlink()
            raise
        done = Recording(
            id=id,
            name=name,
            started=started,
            seconds=float(rows["t_ns"][-1]) * 1e-9,
            rows=len(rows),
            gaps=0,
            bytes=path.stat().st_size,
            actuator="",
            twin=False,
            complete=True,
            rig=IMPORT_RIG,
            imported=True,
        )
        sidecar.write(folder, done)
    return done


def tip_rows(samples: Samples) -> Rows:
    """One row a sample: its tip and its time, counted from the first one; nan for all that was not measured."""
    rows = np.zeros(len(samples.t), record_dtype(Telemetry))
    for field in rows.dtype.names or ():
        if rows.dtype[field].base.kind == "f":
            rows[field] = np.nan
    rows["tick"] = np.arange(len(rows))
    rows["t_ns"] = np.rint((samples.t - samples.t[0]) * 1e9)
    rows["p_meas"] = samples.p
    same = np.flatnonzero(np.diff(rows["t_ns"]) <= 0)
    if same.size:
        line = samples.lines[same[0] + 1]
        raise DataError(f"{samples.path.name}, line {line}: t is less than 1 ns after the line before")
    return rows


def _info(started: datetime) -> RigInfo:
    """Where another lab's clock stood is not known: the first row is put at the time of the import."""
    return RigInfo(
        rig=IMPORT_RIG,
        boot=0,
        version=our_version(),
        commit=commit(),
        layout=layout_hash(Command, Telemetry),
        wall_offset_ns=int(started.timestamp() * 1e9),
        policy="none",
        twin=False,
        parameters=RigParameters(),
    )
