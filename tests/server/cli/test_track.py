"""`tendril track` at the command line."""

import hashlib
import json
import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest

from controller.errors import TendrilError
from controller.schema.actuator import PRESETS
from controller.schema.modes import Law
from controller.schema.origin import Origin
from controller.system.origin import commit, our_version
from recordings.read.reader import read_rows
from server.cli.main import app
from server.cli.research.track import number

pytestmark = pytest.mark.keyed("server/cli/research/commands.py")


def run(*arguments: object) -> None:
    app(["track", *(str(one) for one in arguments)], standalone_mode=False)


def circle(folder: Path, frequency: float = 1.0, radius: float = 0.03, scale: float = 1.0) -> Path:
    file = folder / "ring.csv"
    turns = [(0.01 * i, 2.0 * math.pi * frequency * 0.01 * i) for i in range(600)]
    rows = [f"{t},{scale * (0.03 + radius * math.cos(a))},{scale * (0.14 + radius * math.sin(a))}" for t, a in turns]
    file.write_text("\n".join(["t,x,y", *rows]) + "\n")
    return file


def test_a_path_is_followed_shown_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--actuator", "P3", "--law", "ff+p", "--plant-scale", "k=1.1,delay=0.01", "--seed", "3"]
    for name in ("one.json", "again.json"):
        run("--reference", circle(tmp_path), *options, "--json", tmp_path / name)
    told, again = (json.loads((tmp_path / name).read_text()) for name in ("one.json", "again.json"))
    assert told["rows"] == again["rows"]
    assert {(row["experiment"], row["actuator"], row["law"]) for row in told["rows"]} == {("ring", "P3", "ff+p")}
    assert all(math.isfinite(row["ours"]) for row in told["rows"])
    assert told["seconds"] > 0.0
    shown = capsys.readouterr().out
    assert "1 Hz; 2 s of approach before; velocity feedforward on" in shown
    assert "lag_deg_x" in shown and "whole run" in shown


def test_every_tick_and_a_drawing_are_written_with_their_origin(tmp_path: Path) -> None:
    path, out = circle(tmp_path), {kind: tmp_path / f"run.{kind}" for kind in ("csv", "parquet", "rrd", "svg", "json")}
    run("--reference", path, "--out", out["csv"], "--comments", "--plot", out["svg"], "--json", out["json"])
    told = json.loads(out["json"].read_text())
    made = Origin.model_validate(told["origin"])
    assert made.files == {"ring.csv": hashlib.sha256(path.read_bytes()).hexdigest()}
    assert (made.version, made.commit, made.seeds) == (our_version(), commit(), (0,))
    assert made.actuators == (PRESETS["P1"],) and made.settings and made.settings.law == Law.FF_PI
    assert made.plant and made.plant.model_dump(mode="json") == told["twin"]
    assert out["csv"].read_text().startswith(f'# version: "{our_version()}"\n')
    found = pd.read_csv(out["csv"], comment="#")
    assert len(found) == round(1e3 * (told["reference"]["approach"] + told["reference"]["duration"])) + 1
    error = (
        found[["p_ref_x [m]", "p_ref_y [m]"]].to_numpy() - found[["twin_backbone_20_x [m]", "twin_backbone_20_y [m]"]]
    )
    rmse = 1e3 * math.sqrt((error.to_numpy() ** 2).sum(axis=1).mean())
    assert rmse == pytest.approx(told["windows"]["whole run"]["rmse"], rel=1e-3)
    drawing = ElementTree.parse(out["svg"]).getroot()
    texts = "".join(drawing.itertext())
    assert (
        "x [mm]" in texts
        and "reference minus tip [mm]" in texts
        and hashlib.sha256(path.read_bytes()).hexdigest() in texts
    )
    run("--reference", path, "--out", out["parquet"], "--plot", tmp_path / "run.pdf")
    table = pyarrow.parquet.read_table(out["parquet"])
    np.testing.assert_array_equal(table["p_hat_x"].to_numpy(), found["p_hat_x [m]"].to_numpy())
    assert Origin.model_validate_json(table.schema.metadata[b"origin"]).settings == made.settings
    assert (tmp_path / "run.pdf").read_bytes().startswith(b"%PDF")
    run("--reference", path, "--out", out["rrd"])
    np.testing.assert_array_equal(read_rows(out["rrd"], ("p_hat",))["p_hat"][:, 0], found["p_hat_x [m]"])


def test_a_run_that_breaks_off_is_an_error_and_still_written(tmp_path: Path) -> None:
    with pytest.raises(TendrilError, match="TRACKING_ERROR"):
        weak = ("--plant-scale", "k=2,torque=0.5", "--law", "ff+p")
        run("--reference", circle(tmp_path, 1.0, 0.05), *weak, "--json", tmp_path / "broken.json")
    told = json.loads((tmp_path / "broken.json").read_text())
    assert "TRACKING_ERROR" in told["failed"]
    assert all(row["ours"] is None for row in told["rows"])


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--actuator", "P9"], "actuator = 'P9' is not one of P1, P2, P3"),
        (["--law", "pid"], "law = 'pid' is none of ff, ff\\+p"),
        (["--controller", "mpc"], "controller = 'mpc' is not one of paper, letter, preview, adaptive"),
        (["--plant-scale", "mass=2"], "'mass' is not one of k, b"),
        (["--frequency", "0"], "frequency = 0 Hz is outside"),
        (["--start", "-1"], "start = -1 s is outside \\[0, inf\\)"),
        (["--out", "run.xlsx"], "out = 'run.xlsx' ends in none of .csv, .parquet, .rrd"),
        (["--plot", "run.png"], "plot = 'run.png' ends in none of .svg, .pdf"),
        (["--plot", "/nowhere/run.pdf"], "/nowhere/run.pdf cannot be written: its folder does not exist"),
        (["--json", "/tmp"], "/tmp cannot be written: it is a folder"),
        (["--json", "/nowhere/figures.json"], "/nowhere/figures.json cannot be written: its folder does not exist"),
    ],
)
def test_a_wrong_request_is_said_in_one_line(tmp_path: Path, options: list[str], complaint: str) -> None:
    with pytest.raises(TendrilError, match=complaint) as caught:
        run("--reference", circle(tmp_path), *options)
    assert "\n" not in str(caught.value)


def test_both_windows_are_shown_and_large_numbers_stay_readable() -> None:
    assert [number(value) for value in (None, 3309.2, 12.345, 0.25)] == ["-", "3309", "12.3", "0.250"]


def test_a_shape_may_be_said_to_begin_later(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("--reference", circle(tmp_path), "--start", 1.5, "--json", tmp_path / "one.json")
    told = json.loads((tmp_path / "one.json").read_text())["reference"]
    assert (told["approach"], told["own_approach"]) == (3.5, 1.5)
    assert "3.5 s of approach, with its first 1.5 s" in capsys.readouterr().out


def test_a_path_in_mm_is_refused_before_anything_runs(tmp_path: Path) -> None:
    with pytest.raises(
        TendrilError, match=r"ring.csv, line 2: .* are x and y in m\? Columns in mm are named x_mm, y_mm"
    ):
        run("--reference", circle(tmp_path, scale=1e3))
