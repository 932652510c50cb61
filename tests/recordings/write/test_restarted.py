"""A recording in which the rig restarted: its ticks begin again, its times do not."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from controller.arrays import Rows
from controller.schema.modes import Mode
from controller.schema.parameters import Settings
from recordings.format.annotations import Approach
from recordings.format.messages import Profile
from recordings.read.metrics import metrics_of
from recordings.read.playback import KEEP_EVERY, read_playback
from recordings.read.quick import prepare
from recordings.read.reader import read_rows
from recordings.store.store import Store
from recordings.write.session import Context
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

SHIFT = 0.01
"""The second boot follows a circle so far beside the first one's [m]."""
LEAD, END = 500, 1100
"""First tick and end of what leads into the run of one of the boots."""


@pytest.fixture(params=["standard", "full"])
def profile(request: pytest.FixtureRequest) -> Profile:
    return request.param  # type: ignore[no-any-return]


@pytest.fixture
def boots() -> tuple[Rows, Rows]:
    first, second = telemetry_rows(2000), telemetry_rows(2000)
    second["t_ns"] += first["t_ns"][-1] - second["t_ns"][0] + 3_000_000_000
    for field in ("p_ref", "p_meas", "target", "markers", "backbone", "twin_backbone"):
        second[field] += SHIFT
    for rows in (first, second):
        rows["mode"] = np.where(rows["tick"] < LEAD, Mode.HOLD, Mode.TRACK)
    return first, second


Made = Callable[[int], Path]


@pytest.fixture
def made(tmp_path: Path, profile: Profile, boots: tuple[Rows, Rows]) -> Made:
    def make(noted: int) -> Path:
        """In the boot `noted`, 0 or 1, the approach is told."""
        recorder = Recorder(tmp_path)
        recorder.start("restarted", rig_info(), Settings(), Context(profile=profile))
        for boot, rows in enumerate(boots):
            for batch in batches(rows, 250):
                recorder.rows(batch)
            if boot == noted:
                recorder.annotate(Approach(LEAD, END))
        id = recorder.stop().id
        recorder.close()
        return Store(tmp_path).path(id)

    return make


def test_it_is_played_in_the_order_in_which_it_was(made: Made, boots: tuple[Rows, Rows]) -> None:
    playback, rows = read_playback(made(0)), np.concatenate(boots)
    t = (rows["t_ns"] - rows["t_ns"][0]) * 1e-9
    assert (np.diff(playback.t) > 0.0).all() and playback.duration == pytest.approx(
        t[rows["tick"] % KEEP_EVERY == 0][-1]
    )
    for i in np.flatnonzero(rows["tick"] % KEEP_EVERY == 0):
        row = playback.row(t[i] + 1e-9)
        for field in ("p_ref", "p_meas", "backbone", "twin_backbone"):
            np.testing.assert_allclose(row[field], rows[field][i], atol=2e-5, err_msg=f"{field}, row {i}")
        np.testing.assert_allclose(row["markers"], rows["markers"][i], atol=2e-5)


@pytest.mark.parametrize("noted", [0, 1])
def test_what_leads_into_a_run_is_that_of_its_own_boot(made: Made, boots: tuple[Rows, Rows], noted: int) -> None:
    path = made(noted)
    first, second = (len(boot) for boot in boots)
    inside = np.zeros(first + second, bool)
    inside[noted * first + LEAD : noted * first + END] = True
    np.testing.assert_array_equal(read_rows(path, ("mode",))["approach"], inside)
    leads = [part for part in prepare(path).stretches if part.kind == "approach"]
    assert len(leads) == 1
    assert leads[0].start == pytest.approx(noted * 5.0 + LEAD * 1e-3, abs=0.01)


def test_the_figures_compare_backbones_of_one_boot(made: Made, boots: tuple[Rows, Rows]) -> None:
    """Only the second one's are of the run; what was before it is 1 cm away."""
    boots[0]["twin_backbone"] += 1.0
    path = made(1)
    wanted = metrics_of(rows_of(boots[1], LEAD, END)).unsensed_rms
    assert wanted is not None and metrics_of(read_rows(path)).unsensed_rms == pytest.approx(wanted, rel=1e-2)


def rows_of(rows: Rows, lead: int, end: int) -> dict[str, np.ndarray]:
    """As `read_rows` gives them of a recording of `rows` alone."""
    found = {name: rows[name] for name in rows.dtype.names or ()}
    found["approach"] = (rows["tick"] >= lead) & (rows["tick"] < end)
    slow = rows["tick"] % 10 == 0
    for name in ("backbone", "twin_backbone", "markers"):
        found |= {name: rows[name][slow], f"{name}_tick": rows["tick"][slow]}
    return found
