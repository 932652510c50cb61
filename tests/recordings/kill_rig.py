"""What a kill -9 of the rig costs a recording: real rig, real server, and rerun's reader as the judge."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rerun.chunk import RrdReader

from controller.realtime.ring import find_ring
from recordings.format.messages import Recording
from recordings.read.reader import read_log
from tests.server.live_server import RigProcess, TestServer, free_environment, wait_for


@dataclass(frozen=True)
class Outcome:
    """The recording that a rig was killed in, its log, and the ticks of both lives that rerun finds in the file."""

    recording: Recording
    log: list[str]
    before: np.ndarray
    after: np.ndarray
    done: int
    """The last tick that the rig had done."""

    @property
    def lost(self) -> int:
        """Ticks that the rig had done and the recording does not hold."""
        return self.done - int(self.before[-1])


def kill_rig_once(folder: Path, wait: float) -> Outcome:
    """Kill the rig `wait` s after it was recorded, start it again, and stop when its new boot is recorded too."""
    free_environment()
    rig = RigProcess(folder)
    server = TestServer(folder, rig.endpoint)
    try:
        page = server.operator()
        id = page.post("/api/recordings", json={"name": "killed rig"}).json()["id"]
        wait_for(lambda: server.services.recorder.state().rows > 200, "rows")
        time.sleep(wait)
        rig.kill()
        newest = find_ring("test", folder).newest()
        assert newest is not None
        wait_for(lambda: server.services.rig.boot() is None, "the server to miss the rig")
        rig.start()
        wait_for(lambda: server.services.rig.boot() == rig.boot, "the rig's new boot")
        recorded = server.services.recorder.state().rows
        wait_for(lambda: server.services.recorder.state().rows > recorded + 500, "rows of the new boot")
        page.operate()
        recording = Recording.model_validate(page.delete("/api/recordings/current").json())
        path = server.services.folder.store.path(id)
        lives = _lives(path)
        return Outcome(recording, [text for _, _, text in read_log(path)], *lives, int(newest["tick"]))
    finally:
        server.close()
        rig.stop()


def _lives(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Ticks before and after the restart, in the settings of time, by rerun's reader alone."""
    batches = [chunk.to_record_batch() for chunk in RrdReader(path).stream().filter(content=["/ticks", "/state"])]
    moving = [batch for batch in batches if "t" in batch.schema.names]
    t, tick = (np.concatenate([batch.column(n).cast("int64").to_numpy() for batch in moving]) for n in ("t", "tick"))
    ticks = tick[np.unique(t, return_index=True)[1]]
    [restart] = np.flatnonzero(np.diff(ticks) <= 0)
    return ticks[: restart + 1], ticks[restart + 1 :]
