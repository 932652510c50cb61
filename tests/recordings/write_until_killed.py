"""A process that records at the rig's pace until it is killed.

It prints the tick that it has handed over last, and how late the machine lets it be [ticks].
"""

import sys
import time
from pathlib import Path

from controller.schema.parameters import Settings
from recordings.write.writer import Recorder
from tests.recordings.lateness import Lateness
from tests.recordings.synthetic import rig_info, telemetry_rows

BATCH = 10


def main(folder: Path) -> None:
    recorder = Recorder(folder)
    recorder.start("killed", rig_info(), Settings())
    lateness = Lateness()
    rows, start = telemetry_rows(120_000), time.monotonic()
    for first in range(0, len(rows), BATCH):
        time.sleep(max(0.0, start + first * 1e-3 - time.monotonic()))
        recorder.rows(rows[first : first + BATCH])
        print(first + BATCH - 1, lateness.ticks, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
