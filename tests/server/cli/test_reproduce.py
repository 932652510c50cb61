"""`tendril reproduce` as its user meets it: table, files, progress, and what is refused before anything runs."""

import io
import json
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from controller.errors import TendrilError
from controller.research.experiments.reproduce import Reproduction
from controller.research.experiments.results import SensedLaw, SensedTrajectory
from controller.schema.actuator import PRESETS
from controller.schema.origin import Origin
from controller.simulation.case import Case, Setup
from recordings.format import tool
from recordings.read.reader import read_about
from server.cli.main import app
from server.cli.research.reproduce import run_reproduce
from server.cli.research.reproduce_table import sensing_table

pytestmark = pytest.mark.keyed("server/cli/research/commands.py")

CASES = (
    *(Case("circle_2hz", "P3", seed=seed) for seed in (3, 4)),
    *(Case("digit_1", seed=3), Case("step", "P1", law="[no_such]", seed=3)),
)


def console() -> Console:
    return Console(file=io.StringIO(), width=100)


def printed(at: Console) -> str:
    assert isinstance(at.file, io.StringIO)
    return at.file.getvalue()


@pytest.mark.process
def test_a_small_reproduction_prints_its_table_and_writes_rows_recordings_and_report(tmp_path: Path) -> None:
    out, file = console(), tmp_path / "rows.json"
    stale = tmp_path / "report" / "recordings" / "step_P1_[no_such].rrd"
    stale.parent.mkdir(parents=True)
    stale.write_text("of an earlier run, which did not fail")
    run_reproduce(Reproduction(CASES, workers=2), tmp_path / "report", file, out)
    found = json.loads(file.read_text())
    made = Origin.model_validate(found["origin"])
    assert list(made.seeds) == found["seeds"] and made.plant and made.plant.model_dump(mode="json") == found["twin"]
    assert {one.name for one in made.actuators} == {row["actuator"] for row in found["rows"]} & set(PRESETS)
    assert {row["experiment"] for row in found["rows"]} == {"circle_2hz", "digit_1"}
    assert [one["law"] for one in found["failures"]] == ["[no_such]"]
    text = printed(out)
    for words in (
        "consulted",
        "circle_2hz P3 ff+pi rmse",
        "± ",
        "Failed: step P1 [no_such], seed 3: law = '[no_such]'",
        "4 runs in",
        "Written:",
    ):
        assert words in " ".join(text.split()), words
    assert (tmp_path / "report" / "index.html").read_text().startswith("<!doctype html>")
    recorded = sorted(tmp_path.glob("report/recordings/*"))
    assert [path.name for path in recorded] == ["circle_2hz_P3_ff+pi.rrd", "digit_1_P1_ff+pi.rrd"]
    for path in recorded:
        tool.run("rrd", "verify", str(path), timeout=60)
    info, settings = read_about(recorded[0])
    assert info.parameters.twin.seed == 3
    assert (info.parameters.actuator.name, settings.K_FF) == ("P3", Setup().gains.K_FF)
    assert read_about(recorded[1])[1].K_FF == (0.0, 0.0)


def test_what_cannot_be_written_is_refused_before_the_first_run(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    cases: tuple[tuple[Path | None, Path | None, str], ...] = (
        (None, tmp_path / "none" / "rows.json", "its folder does not exist"),
        (None, tmp_path, "it is a folder"),
        (blocked, None, "cannot be made"),
        (blocked / "report", None, "cannot be made"),
    )
    for report, file, words in cases:
        with pytest.raises(TendrilError, match=words):
            run_reproduce(Reproduction(CASES), report, file, console())


def test_a_recording_of_an_earlier_run_that_cannot_be_removed_is_named(tmp_path: Path) -> None:
    (tmp_path / "recordings" / "digit_1_P1_ff+pi.rrd").mkdir(parents=True)
    with pytest.raises(TendrilError, match=r"digit_1_P1_ff\+pi\.rrd cannot be removed"):
        run_reproduce(Reproduction(CASES), tmp_path, None, console())


def test_a_trajectory_without_ff_has_no_reductions_in_its_table() -> None:
    laws = tuple(SensedLaw(law, (2.0,), (1.0,), float("nan")) for law in ("rod6", "rod10"))
    out = console()
    out.print(sensing_table((SensedTrajectory("sensing_sweep", laws, 0.27, False, None),)))
    assert "nan" not in printed(out) and "failed" in printed(out)


def test_an_unknown_controller_is_refused_by_name() -> None:
    refused = CliRunner().invoke(app, ["reproduce", "--controller", "smith"])
    assert isinstance(refused.exception, TendrilError)
    assert str(refused.exception) == "controller = 'smith' is not one of paper, letter, preview, adaptive"


@pytest.mark.parametrize("wrong", [["--workers", "0"], ["--seed", "-1"], ["--seed", "x"], ["--fast"]])
def test_numbers_out_of_bounds_and_unknown_options_are_refused(wrong: list[str]) -> None:
    assert CliRunner().invoke(app, ["reproduce", *wrong]).exit_code == 2
