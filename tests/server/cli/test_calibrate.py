"""`tendril calibrate` from the search to the file and the tables, on a problem of one row and two unknowns."""

import sys
import tomllib
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from controller.errors import TendrilError
from controller.research.calibration import calibrate, ensemble, spread
from controller.research.calibration.calibrate import CalibrationTask, require_best
from controller.research.calibration.problem import Problem
from controller.research.calibration.search import Effort, Search
from controller.research.calibration.space import Space
from controller.research.calibration.spread import PRINTS
from controller.research.calibration.unknowns import Unknown
from controller.research.experiments.paper_rows import FITTED, JUDGED
from controller.research.experiments.pool import Pool
from controller.schema.parameters import TwinParameters
from server.cli import main as cli
from server.cli.research.calibrate import run_calibrate

pytestmark = pytest.mark.keyed("server/cli/research/commands.py")

UNKNOWNS = Unknown("torque_gain.0", 0.9, 1.3, 1.05, 5.0), Unknown("K_P", 0.1, 0.4, 0.15, 5.0, log=True)
ROWS = tuple(row for row in FITTED if row.experiment == "horizontal_0.25hz")
PROBLEM = Problem(Space(UNKNOWNS), ROWS, ())
TASK = CalibrationTask(
    PROBLEM,
    Effort(screen=2, starts=1, steps=1, generations=0, rounds=1, minutes=10.0),
    workers=1,
    command="tendril calibrate",
)


@pytest.fixture(autouse=True)
def little_is_held_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spread, "PREDICTED", JUDGED[1:2])
    monkeypatch.setattr(ensemble, "WALKERS", 4)
    monkeypatch.setattr(ensemble, "ATTEMPTS", 2)


def interrupted(*_: Any) -> None:
    raise KeyboardInterrupt


def run(out: Path) -> tuple[dict[str, Any], str]:
    """The file and what was printed."""
    printed = StringIO()
    run_calibrate(TASK, out, Console(file=printed, width=200))
    return tomllib.loads(out.read_text("utf-8")), printed.getvalue()


def test_a_search_ends_in_a_file_and_tables_that_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    read, printed = run(tmp_path / "fit.toml")
    said = capsys.readouterr().err.splitlines()  # its output is no terminal: no bar is seen
    assert said[0].startswith("Searching") and said[1].startswith("screening: 2 at most, best cost ")
    assert read["fit"]["ended"] == "finished" and read["fit"]["evaluations"] > 2 + ensemble.WALKERS
    assert TwinParameters(**read["twin"]).torque_gain[0] == read["twin"]["torque_gain"][0]
    [row], [fitted, held_out] = read["rows"], read["spread"]
    assert (fitted["role"], held_out["role"]) == ("fit", "held-out")
    assert row["ratio"] == pytest.approx(row["ours"] / row["paper"], rel=1e-3)
    assert held_out["low"] <= held_out["median"] <= held_out["high"] and fitted["numbers"] == read["fit"]["fits"]
    assert held_out["numbers"] == 1 + PRINTS * read["fit"]["fits"]  # P2 is another print for every fit
    assert read["discrepancy"]["fit_rows"] == 1 and "1 fit rows" in printed
    for title in ("Fitted rows", "Unknowns", "over the near-equal fits", "Written: "):
        assert title in printed
    assert "Margins" not in printed  # there were no trials
    assert f"{row['ours']:.2f}" in printed and f"{read['gains']['K_P']:g}" in printed


@pytest.mark.parametrize(("module", "part"), [(calibrate, "walk"), (spread, "predict")])
def test_an_interrupt_after_the_search_still_gives_the_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: Any, part: str
) -> None:
    monkeypatch.setattr(module, part, interrupted)
    read, printed = run(tmp_path / "fit.toml")
    assert read["fit"]["ended"] == "interrupted" and "(interrupted)" in printed
    assert len(read["rows"]) == 1 and len(read.get("spread", [])) == (2 if part == "walk" else 0)


def test_a_file_that_fails_after_the_search_costs_no_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibrate, "walk", interrupted)
    monkeypatch.setattr("server.cli.research.calibrate.require_file", lambda out: (tmp_path / "fit.toml").mkdir())
    printed = StringIO()
    with pytest.raises(TendrilError, match="cannot be written: Is a directory"):
        run_calibrate(TASK, tmp_path / "fit.toml", Console(file=printed, width=200))
    assert "Fitted rows" in printed.getvalue() and "Written" not in printed.getvalue()


def test_a_search_in_which_nothing_keeps_the_margins_says_how_it_ended() -> None:
    with Pool(1) as pool, pytest.raises(TendrilError, match=r"^0 points \(interrupted\), none of which kept"):
        require_best(Search(PROBLEM, pool, TASK.effort), "interrupted")


def test_quick_asks_for_no_margins_and_the_command_is_quoted(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[CalibrationTask] = []
    monkeypatch.setattr("server.cli.research.calibrate.run_calibrate", lambda task, out, console: given.append(task))
    monkeypatch.setattr(sys, "argv", ["tendril", "calibrate", "--out", "my fit.toml"])
    cli.app(["calibrate", "--quick", "--starts", "3"], standalone_mode=False)
    [task] = given
    assert task.problem.trials == () and task.effort.starts == 3 and task.effort.screen < Effort().screen
    assert task.command == "tendril calibrate --out 'my fit.toml'"
