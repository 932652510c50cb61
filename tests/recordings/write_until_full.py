"""A process that may write files of 1 MB at most, and records more; it prints the problem that the recorder reports."""

import resource
import sys
import time
from pathlib import Path

from controller.schema.parameters import Settings
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows


def main(folder: Path) -> None:
    recorder = Recorder(folder)
    recorder.start("full", rig_info(), Settings())
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))
    for batch in batches(telemetry_rows(60_000)):
        recorder.rows(batch)
        time.sleep(0.002)
        if not recorder.state().recording:  # a disk that answers late is a problem, too, and passes
            break
    print(recorder.state().problem)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
