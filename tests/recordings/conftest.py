"""A recorder in a folder of its own, and recordings made with it."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from controller.arrays import Rows
from controller.schema.parameters import Settings
from recordings.format.messages import Recording
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info


@pytest.fixture
def recorder(tmp_path: Path) -> Iterator[Recorder]:
    recorder = Recorder(tmp_path)
    yield recorder
    recorder.close()


@pytest.fixture
def record(recorder: Recorder) -> Callable[..., Recording]:
    def run(rows: Rows, name: str = "Circle, 0.5 Hz") -> Recording:
        recorder.start(name, rig_info(), Settings())
        for batch in batches(rows):
            recorder.rows(batch)
        return recorder.stop()

    return run
