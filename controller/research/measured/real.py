"""All sets of measured data, one table."""

from pathlib import Path

from controller.research.measured.limb import LIMB
from controller.research.measured.regulator import REGULATOR
from controller.research.measured.sets import Question, Row, UnreadSet, require_folder, rows, unread_row
from controller.research.measured.tentacle import TENTACLE
from controller.research.measured.trunk import TRUNK
from controller.system.progress import ProgressCallback, no_progress

SETS = (LIMB, REGULATOR, TENTACLE, TRUNK)
ARM = UnreadSet(
    name="soft arm",
    source="github.com/Jeevan-HM/Soft-Robotic-Arm, data/_data_extract at dcd376e",
    licence="MIT",
    question=Question("the tip in 30 conditions, after a fit to six", "rms distance", "% of length"),
    baselines={"their twin": 1.0},
    why="data/_data_extract: it bends in space under four pouches, and this command does not read it yet",
)


def benchmark(folder: Path, told: ProgressCallback = no_progress) -> list[Row]:
    """A row for each question of every set, of the repositories that lie in `folder`.

    Raises ParameterError where that is no folder, DataError for a file that cannot be read.
    """
    require_folder(folder)
    found = []
    for done, one in enumerate(SETS, 1):
        found += rows(one, folder)
        told(done / len(SETS))
    return [*found, unread_row(ARM)]
