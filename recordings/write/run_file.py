"""A simulated run as a recording: the same file as of a live rig, with the same layout."""

from pathlib import Path

from controller.arrays import Rows
from controller.schema.layout import layout_hash
from controller.schema.messages import Command, RigInfo, Telemetry
from controller.schema.parameters import RigParameters, Settings
from controller.system.origin import commit, our_version
from recordings.format.about import About
from recordings.write.rrd import write_whole

THINNED = 5
"""One tick of this many is recorded: 200 Hz, a third of the size of them all."""


def write_run(rows: Rows, path: Path, name: str, parameters: RigParameters, settings: Settings) -> None:
    """The run `rows` (n,) of Telemetry into the file `path`; RecordingError when it cannot be written.

    A simulated clock has no date: the time line `time` begins in 1970.
    """
    about = About(path.stem, f"{name}, every {THINNED}th tick", simulated_rig(parameters), settings)
    write_whole(path, about, rows[rows["tick"] % THINNED == 0])


def write_every_row(rows: Rows, path: Path, name: str, parameters: RigParameters, settings: Settings) -> None:
    """As `write_run`, every tick."""
    write_whole(path, About(path.stem, name, simulated_rig(parameters), settings), rows)


def simulated_rig(parameters: RigParameters) -> RigInfo:
    """What a recording says of a rig that is only simulated."""
    return RigInfo(
        rig="twin",
        boot=1,
        version=our_version(),
        commit=commit(),
        layout=layout_hash(Command, Telemetry),
        wall_offset_ns=0,
        policy="simulated",
        twin=True,
        parameters=parameters,
    )
