"""For how long things lie somewhere, by the time that this machine ran: a wall clock that jumps makes nothing older.

The ages are in a file, and each look adds what has passed since the last one of the same boot of the machine, whichever
process looked. What passed between two boots is not known and does not count: things rather stay too long.
"""

import time
from collections.abc import Iterable
from pathlib import Path

from pydantic import Field as Bounds
from pydantic import ValidationError

from controller.schema.layout import Model
from controller.system.whole_file import read_whole, write_whole

BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


class Ages(Model):
    """What the file holds: when it was written, and how old each thing was then."""

    boot: str = ""
    """The id of the machine's boot."""
    at: float = 0.0
    """Since that boot, sleep included [s]."""
    ages: dict[str, float] = Bounds(default_factory=dict)
    """By name [s]."""

    def now(self, names: Iterable[str]) -> "Ages":
        """The same at this moment for `names` alone; what was not there is 0 s old."""
        boot, at = machine_time()
        passed = max(0.0, at - self.at) if boot == self.boot else 0.0
        return Ages(
            boot=boot, at=at, ages={name: self.ages[name] + passed if name in self.ages else 0.0 for name in names}
        )


def machine_time() -> tuple[str, float]:
    """The id of this boot of the machine, and the time since it began, sleep included [s]."""
    return BOOT_ID.read_text().strip(), time.clock_gettime(time.CLOCK_BOOTTIME)


def read_ages(path: Path) -> Ages:
    """The ages in the file; none where it is missing or damaged: all is young then."""
    try:
        return Ages.model_validate_json(read_whole(path))
    except (OSError, ValidationError):
        return Ages()


def write_ages(path: Path, ages: Ages) -> None:
    """Keep them; OSError where that fails."""
    write_whole(path, ages.model_dump_json(), lasting=False)
