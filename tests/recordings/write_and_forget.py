"""A process that writes one file after the other; prints by how much it grew per file [MB]. Folder, settle, count."""

import ctypes
import sys
from pathlib import Path

import psutil

from controller.schema.parameters import Settings
from recordings.format.about import About
from recordings.write.rrd import write_whole
from tests.recordings.synthetic import rig_info, telemetry_rows


def main() -> None:
    """Write, and look after `settle` files and after `count` more."""
    folder, settle, count = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    rows, sizes = telemetry_rows(100), []
    for k in range(settle + count):
        if k == settle:
            sizes.append(resident())
        path = folder / f"{k}.rrd"
        write_whole(path, About(f"{k}", "name", rig_info(), Settings(), "full"), rows)
        path.unlink()
    print((resident() - sizes[0]) / count)


def resident() -> float:
    """What is in memory, without what malloc holds for later [MB]."""
    ctypes.CDLL(None).malloc_trim(0)
    return psutil.Process().memory_info().rss / 1e6


if __name__ == "__main__":
    main()
