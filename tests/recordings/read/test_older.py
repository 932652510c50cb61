"""A recording of an older version, which knew fewer signals, is read like any other."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from controller.schema.parameters import Settings
from recordings.exporting.export import export, export_for_viewer
from recordings.exporting.table import Choice
from recordings.format.messages import Profile
from recordings.format.signals import GROUPS
from recordings.read.playback import read_playback
from recordings.read.quick import prepare
from recordings.read.reader import read_groups, read_rows
from recordings.write import rrd
from recordings.write.rrd import About, RrdFile
from tests.recordings.synthetic import rig_info, telemetry_rows

LATEST, WITH_IT = "signals", 9
"""The signal that was added last, and how many series came with it."""


@pytest.fixture(params=["standard", "full"])
def older(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Written without it, as the version before did."""
    profile: Profile = request.param
    assert rrd.GROUPS[-1].series[-1].field == LATEST, "what is new comes last"
    fewer = replace(rrd.GROUPS[-1], series=rrd.GROUPS[-1].series[:-WITH_IT])
    monkeypatch.setattr(rrd, "GROUPS", (*rrd.GROUPS[:-1], fewer))
    path = tmp_path / "older.rrd"
    file = RrdFile(path, About("older", "older", rig_info(), Settings(), profile))
    file.write(telemetry_rows(400))
    file.close()
    return path


def test_its_rows_are_whole_and_what_it_lacks_is_zero(older: Path) -> None:
    found, wanted = read_rows(older), telemetry_rows(400)
    for field in ("mode", "slot", "reachable", "u"):
        np.testing.assert_allclose(found[field], wanted[field], atol=2e-5)
    assert not found[LATEST].any() and len(found[LATEST]) == len(found.get(f"{LATEST}_tick", found["tick"]))


def test_it_is_looked_at_and_played(older: Path) -> None:
    quick, playback = prepare(older), read_playback(older)
    assert quick.rows == 400 and all(signal.values for signal in quick.signals)
    np.testing.assert_allclose(playback.row(0.2)["p_ref"], telemetry_rows(400)["p_ref"][200], atol=1e-3)


def test_it_is_exported_without_what_it_lacks(older: Path) -> None:
    export(older, older.with_suffix(".csv"), "csv", Choice())
    header = older.with_suffix(".csv").read_text().partition("\n")[0]
    assert "reachable" in header and LATEST not in header
    export_for_viewer(older, older.with_name("shown.rrd"), dark=True)
    groups = read_groups(older.with_name("shown.rrd"), GROUPS)
    assert groups["/u"].values.shape[1] == 8 and len(groups["/u"].t) in (40, 400)
