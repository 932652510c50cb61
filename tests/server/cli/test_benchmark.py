"""`tendril benchmark real`: the table and its JSON, with what is there and what is missing."""

import json
import shutil
from hashlib import sha256
from pathlib import Path

import pytest

from controller.errors import TendrilError
from controller.research.measured.real import SETS
from server.cli.main import app

pytestmark = pytest.mark.keyed("server/cli/research/benchmark.py", "tests/data")

DATA = Path(__file__).parents[2] / "data"
FIELDS = {"set", "question", "metric", "unit", "ours", "baselines", "files", "missing"}


def run(*arguments: object) -> None:
    app([str(one) for one in arguments], standalone_mode=False)


def test_what_is_there_is_answered_and_what_is_not_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("benchmark", "real", "--data", DATA, "--json", tmp_path / "real.json")
    found = json.loads((tmp_path / "real.json").read_text())["rows"]
    assert all(set(row) == FIELDS for row in found)
    assert {row["set"] for row in found} == {one.name for one in SETS}
    for row in found:
        assert (row["ours"] is None) == bool(row["missing"])
        assert row["ours"] is None or 0.0 < row["ours"] < 50.0
    body_2, body_1 = [row for row in found if row["set"] == "trunk decays"]
    for row in (body_2, body_1):
        assert row["ours"] < min(row["baselines"]["constant curvature"], row["baselines"]["fixed ratio"])
    for inner, hashed in body_2["files"].items():
        assert hashed == sha256((DATA / inner).read_bytes()).hexdigest()
    said = capsys.readouterr().out
    assert "missing: cpp_examples/real2sim_case/soft_limb_data.csv" in said
    assert "missing: 29 more beside these" in said
    assert "is to be had from github.com/StructuresComp/dismech-rods (licence: GPL-3.0)" in said


def test_a_repository_is_found_some_folders_down(tmp_path: Path) -> None:
    shutil.copytree(DATA / "soromox", tmp_path / "github.com" / "tud-phi" / "soromox")
    run("benchmark", "real", "--data", tmp_path, "--json", tmp_path / "real.json")
    found = json.loads((tmp_path / "real.json").read_text())["rows"]
    assert [row["set"] for row in found if row["ours"] is not None] == ["hanging tentacle"] * 2


def test_a_folder_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TendrilError, match=r"data = .*gone is no folder"):
        run("benchmark", "real", "--data", tmp_path / "gone")
