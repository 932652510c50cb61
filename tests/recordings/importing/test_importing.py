"""Another lab's path becomes a recording like any other."""

from pathlib import Path

import numpy as np
import pytest

from controller.errors import DataError, RecordingError
from controller.reference.path_file import read_samples
from recordings.exporting.export import export
from recordings.exporting.signals import offered
from recordings.exporting.table import Choice, RowReader
from recordings.format import tool
from recordings.format.messages import Recording
from recordings.importing.tip import import_tip
from recordings.read.reader import read_rows
from recordings.store.store import Store

T = np.array([100.0, 100.01, 100.025, 101.0])
P = np.array([(0.25, 0.0), (0.24, 0.01), (0.23, 0.025), (0.1, 0.2)])


def imported(folder: Path, text: str, **units: str) -> Recording:
    file = folder / "lab.csv"
    file.write_text(text)
    return import_tip(folder, "Their circle", read_samples(file, {"t": "s", "x": "m", "y": "m"} | units))


def millimetres(header: str, delimiter: str = ",") -> str:
    lines = [delimiter.join(f"{value:g}" for value in (t, *(1e3 * p))) for t, p in zip(T, P, strict=True)]
    return "\n".join([header, *lines]) + "\n"


@pytest.mark.process
def test_it_is_listed_verified_by_rerun_and_holds_what_was_measured(tmp_path: Path) -> None:
    done = imported(tmp_path, millimetres("time;x [mm];y [mm]", ";"))
    (listed,) = Store(tmp_path).list()
    assert listed == done
    assert (done.imported, done.rows, done.complete, done.name) == (True, 4, True, "Their circle")
    assert done.seconds == pytest.approx(1.0)
    path = Store(tmp_path).path(done.id)
    tool.run("rrd", "verify", str(path), timeout=60)
    rows = read_rows(path)
    np.testing.assert_allclose(rows["p_meas"], P, atol=1e-15)
    assert rows["t_ns"].tolist() == [0, 10_000_000, 25_000_000, 1_000_000_000]
    assert np.isnan(rows["p_ref"]).all() and np.isnan(rows["u"]).all()


def test_its_export_has_the_tip_and_nothing_that_was_not_measured(tmp_path: Path) -> None:
    done = imported(tmp_path, millimetres("t,x_mm,y_mm"))
    path = Store(tmp_path).path(done.id)
    names = [column.signal.name for column in RowReader(path).table(Choice()).columns]
    assert names == [signal.name for signal in offered(done)] == ["tick", "t_ns", "p_meas_x", "p_meas_y"]
    export(path, tmp_path / "again.csv", "csv", Choice(("p_meas",)))
    lines = (tmp_path / "again.csv").read_text().splitlines()
    assert lines[0] == "t [s],p_meas_x [m],p_meas_y [m]"
    assert lines[2].split(",")[0] == "0.01"


def test_units_that_the_header_does_not_name_can_be_said(tmp_path: Path) -> None:
    done = imported(tmp_path, millimetres("t,x,y [mm]"), x="mm", y="cm")
    np.testing.assert_allclose(read_rows(Store(tmp_path).path(done.id))["p_meas"], P, atol=1e-15)


def test_times_that_cannot_be_told_apart_are_refused_and_leave_nothing(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"lab.csv, line 3: t is less than 1 ns after the line before"):
        imported(tmp_path, "t,x,y\n1,0,0\n1.0000000001,0,0\n")
    assert [path.name for path in tmp_path.iterdir()] == ["lab.csv"]


def test_a_disk_that_is_nearly_full_takes_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recordings.write.session.DISK_FREE_MIN", 1 << 62)
    with pytest.raises(RecordingError, match="MiB are free"):
        imported(tmp_path, "t,x,y\n1,0,0\n2,0,0\n")
    assert [path.name for path in tmp_path.iterdir()] == ["lab.csv"]
