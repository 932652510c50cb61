"""All sets of measured data, one table."""

from pathlib import Path

from controller.research.measured.arm import ARM
from controller.research.measured.limb import LIMB
from controller.research.measured.regulator import REGULATOR
from controller.research.measured.sets import Row, require_folder, rows
from controller.research.measured.tentacle import TENTACLE
from controller.research.measured.trunk import TRUNK
from controller.system.progress import ProgressCallback, no_progress

SETS = (LIMB, REGULATOR, TENTACLE, ARM, TRUNK)


def benchmark(folder: Path, told: ProgressCallback = no_progress) -> list[Row]:
    """A row for each question of every set, of the repositories that lie in `folder`.

    Raises ParameterError where that is no folder, DataError for a file that cannot be read.
    """
    require_folder(folder)
    found = []
    for done, one in enumerate(SETS, 1):
        found += rows(one, folder)
        told(done / len(SETS))
    return found
