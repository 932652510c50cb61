"""A rig that is killed with -9 while the server records."""

from pathlib import Path

import numpy as np
import pytest

from tests.recordings.kill_at_random import LOSS_MAX
from tests.recordings.kill_rig import kill_rig_once

pytestmark = pytest.mark.alone


def test_a_recording_outlives_a_killed_rig_and_says_so(tmp_path: Path) -> None:
    left = kill_rig_once(tmp_path, wait=1.0)
    print(f"{left.lost} ticks lost of the {left.done} that the rig had done")
    assert 0 <= left.lost <= LOSS_MAX
    assert (np.diff(left.before) == 1).all() and (np.diff(left.after) == 1).all()
    assert left.after[0] == 0 and len(left.after) >= 500
    recording = left.recording
    assert (recording.complete, recording.gaps, recording.rows) == (True, 0, len(left.before) + len(left.after))
    [restart] = recording.restarts
    assert restart.after == left.before[-1] and restart.seconds > 0.1
    told = "\n".join(left.log)
    assert "the rig is gone" in told and f"s after tick {restart.after}" in told and "restarted" in told
