"""The report of a small reproduction: what it must show, and what it must not hide."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from controller.errors import TendrilError
from controller.research.experiments.fitted_intervals import with_intervals
from controller.research.experiments.paper_rows import paper_row
from controller.research.experiments.reproduce import Reproduction, reproduce
from controller.research.experiments.results import Failure, ResultRow, Results, SensedTrajectory
from controller.research.report.bars import covered, sensing
from controller.research.report.figures.periodic_figures import circle_plate
from controller.research.report.figures.plate import plate_html
from controller.research.report.figures.snapshot_figures import outline
from controller.research.report.main_table import remarks
from controller.research.report.page import report_page, write_report
from controller.research.report.remarks import known_remarks, needs_remark, outdated
from controller.research.report.result_json import row_json
from controller.research.report.spans import once
from controller.research.report.verdict import verdict
from controller.schema.fit import FIT
from controller.simulation.case import Case
from controller.simulation.metrics import Window
from tests.controller.balance import Balance

pytestmark = pytest.mark.keyed()

CASES = (
    Case("step", law="ff"),
    Case("step"),
    Case("digit_1"),
    Case("circle_1hz"),
    Case("circle_1hz", seed=1),
    Case("vertical_1hz"),
    *(Case("sensing_sweep", law=law, seed=seed) for law in ("ff", "rod10", "rod6+10") for seed in (0, 1)),
    Case("frequency_sweep_1hz"),
)

BROKEN = Failure(Case("vu"), "vu: FAULT (TRACKING_ERROR) after 3.210 s, instead of to the end")
KEY = {"experiment": "circle_1hz", "actuator": "P1", "law": "ff+pi", "metric": "rmse"}


@pytest.fixture(scope="module")
def results() -> Results:
    found = reproduce(Reproduction(cases=CASES, quick=True), lambda case: None)
    return replace(found, failures=(BROKEN,), rows=(*found.rows, failed_row(BROKEN)))


@pytest.fixture(scope="module")
def page(results: Results) -> str:
    return report_page(results, FIT)


def result_row(what: str, ours: float | None, failed: str = "") -> ResultRow:
    experiment, actuator, law, metric = what.split()
    about = paper_row(experiment, actuator, law, metric)
    return ResultRow(about, ours, None, Window.WHOLE, ours, 1, failed)


def failed_row(failure: Failure) -> ResultRow:
    case = failure.case
    return result_row(f"{case.reference} {case.actuator} {case.law} rmse", None, failure.sentence)


def test_the_page_is_whole_and_needs_nothing_outside_itself(page: str) -> None:
    balance = Balance()
    balance.feed(page)
    assert balance.open == []
    assert re.findall(r'(?:src|href)="(?!#|data:)', page) == []
    assert "nan" not in re.sub(r"<[^>]*>", "", page)
    assert len(page.encode()) < 6_000_000


def test_every_number_of_a_run_is_beside_the_papers(results: Results, page: str) -> None:
    row = next(row for row in results.rows if row.about.key == ("circle_1hz", "P1", "ff+pi", "rmse"))
    cells = re.search(r"<tr><td>circle_1hz, P1, FF\+PI</td><td>RMSE \[mm\]</td>(.*?)</tr>", page)
    assert cells is not None
    text = re.sub(r"<[^>]*>", " ", cells[1])
    assert row.ours is not None and row.ratio is not None and row.ours_other_window is not None
    for expected in ("7.4", f"{row.ours:.3g}"[:3], f"{row.ratio:.2f}", "fit", f"{row.ours_other_window:.3g}"[:3]):
        assert expected in text


def test_a_failed_run_stands_with_its_sentence_where_its_number_and_its_figure_would_be(page: str) -> None:
    tables, figure = page.count(f"<td>{BROKEN.sentence}</td>"), page.count(f"Failed: {BROKEN.sentence}")
    assert tables == 1 and figure == 1
    assert re.search(r"vu, P1, FF\+PI.{0,300}failed", page)
    assert f"1 of {len(CASES) + 1} runs failed" in page


def test_what_was_not_run_is_said(results: Results) -> None:
    nothing = replace(results, outcomes=(), failures=(), rows=(), sensing=(), sweep=(), pressure=(), observer=())
    page = report_page(nothing, FIT)
    for text in ("Held-out rows: none was run", "Not run: circle_2hz, P3, FF+PI.", "Not run: pressure steps."):
        assert text in page
    assert "<svg" not in page


def test_the_same_results_are_drawn_to_the_same_bytes(results: Results) -> None:
    first, again = (plate_html(circle_plate(results)) for _ in range(2))
    assert first == again
    assert first.count("<svg") == 4


def test_spread_and_margins_are_shown_as_soon_as_the_fit_has_them(results: Results) -> None:
    numbers = replace(results, outcomes=(), sensing=(), sweep=(), pressure=(), observer=())
    fit: dict[str, Any] = {**FIT, "spread": [], "margins": []}
    numbers = replace(numbers, rows=with_intervals(numbers.rows, numbers.setup, fit))
    assert "near-equal" not in report_page(numbers, fit)
    fit["spread"] = [{**KEY, "low": 5.123, "high": 12.34, "numbers": 9}]
    fit["margins"] = [{"actuator": "P2", "change": "gains", "swing_mm": 0.123}]
    later = report_page(replace(numbers, rows=with_intervals(numbers.rows, numbers.setup, {**FIT, **fit})), fit)
    for text in (f"interval of {FIT['fit']['fits']} near-equal fits", "5.12 .. 12.3", "swing [mm]", "0.12"):
        assert text in later


def test_every_row_that_is_not_near_is_listed_with_its_reason_or_that_there_is_none() -> None:
    known = {"circle_1hz P1 ff+pi rmse": "The sheet <drags>."}
    near, far = (result_row("circle_1hz P1 ff+pi rmse", ours) for ours in (7.5, 10.0))
    assert (remarks([near], known), outdated([near], known)) == ("", ["circle_1hz P1 ff+pi rmse"])
    assert "The sheet &lt;drags&gt;." in remarks([far], known) and outdated([far], known) == []
    for what, ours in (("vu P1 ff+pi rmse", 10.0), ("vu P2 ff+pi rmse", 3.7 * 1.31), ("step P1 ff rmse", 20.0)):
        assert "no reason known" in remarks([result_row(what, ours)], known)
    assert "broke off" in remarks([result_row("vu P1 ff+pi rmse", None, "broke off")], known)
    assert remarks([result_row("step P1 ff sse", 1.0), result_row("step P1 ff ise", 1.0)], known) == ""


def test_the_json_row_has_the_remark() -> None:
    far, near = (row_json(result_row("vu P2 ff+pi rmse", ours)) for ours in (6.0, 3.7))
    assert far["remark"] and "remark" not in near


def test_remarks_are_about_rows_that_may_need_one() -> None:
    for key in known_remarks():
        assert needs_remark(result_row(key, 1e6))


@pytest.mark.parametrize(
    ("what", "ours", "word", "met"),
    [
        ("circle_1hz P1 ff+pi rmse", 7.4 * 1.19, "within 20 %", True),
        ("circle_1hz P1 ff+pi rmse", 7.4 * 0.79, "over 20 %", False),
        ("step P1 ff+pi sse", 3.0, "no bar", None),
        ("step P1 ff step_spread", 3.0, "no bar", None),
        ("sensing_circle P1 rod6 reduction", 60.0, "within 15 points", True),
        ("sensing_circle P1 rod6 reduction", 58.0, "over 15 points", False),
        ("vu P2 ff+pi rmse", 3.7 * 0.71, "within 30 %", True),
        ("vu P2 ff+pi rmse", 3.7 / 1.49, "within 1.5", True),
        ("vu P2 ff+pi rmse", 3.7 / 1.51, "over 1.5", False),
        ("circle_2hz P3 ff+pi lag_deg_x", -27.0, "over 1.5", False),
        ("digit_3 P1 ff+pi max_x", 4.9, "inside", True),
        ("digit_3 P1 ff+pi rmse", 1.4, "outside", False),
        ("circle_1hz P1 ff+pi ise", 1.0, "", None),
        ("vu P2 ff+pi rmse", None, "failed", False),
    ],
)
def test_a_row_is_judged_by_the_bar_of_its_role(what: str, ours: float | None, word: str, met: bool | None) -> None:
    found = verdict(result_row(what, ours))
    assert (found.word, found.met) == (word, met)


def test_the_bars_say_how_many_fit_rows_are_inside_and_how_many_reductions_are_near(results: Results) -> None:
    inside = [replace(result_row("vu P1 ff+pi rmse", 2.0), interval=(1.0, 3.0))] * 4
    outside = replace(result_row("step P1 ff rmse", 20.0), interval=(1.0, 3.0))
    foreign = replace(result_row("vu P2 ff+pi rmse", 2.0), interval=(1.0, 3.0))  # no fit row
    found = replace(results, rows=(*inside, outside, foreign, result_row("step P1 ff sse", 20.0)))
    assert covered(found) == "Fitted rows with the paper in their interval: 4 of 5 = 80 % (wanted: 80 to 97 %)."
    assert covered(replace(results, rows=())) == ""
    sweeps = tuple(result_row("sensing_sweep P1 rod6 reduction", ours) for ours in (27.0, 42.0, 43.0, None))
    task_4 = replace(results, rows=sweeps, sensing=(SensedTrajectory("sensing_sweep", (), 0.27, True, None),))
    assert "on 1 of 1 trajectories, 2 of 4 reductions within 15 points" in sensing(task_4)


def test_a_reference_is_drawn_once_whole_and_not_there_and_back(results: Results) -> None:
    circle, vertical = (results.of(name)[0] for name in ("circle_1hz", "vertical_1hz"))
    ends = circle.trace.p_ref[once(circle)][[0, -1]]
    assert np.linalg.norm(ends[1] - ends[0]) < 1e-3
    y = vertical.trace.p_ref[once(vertical), 1]
    assert np.ptp(y) == pytest.approx(60e-3, abs=1e-4)
    assert (np.diff(y) < 0.0).all()


def test_the_outline_of_a_body_is_its_width_apart() -> None:
    turn = np.linspace(0.0, 1.5, 40)
    backbone = np.column_stack([np.sin(turn), 1.0 - np.cos(turn)])
    left, right = np.split(outline(backbone, 0.1), 2)
    assert np.linalg.norm(left - right[::-1], axis=1) == pytest.approx(0.1)
    assert 0.5 * (left + right[::-1]) == pytest.approx(backbone)


def test_a_folder_that_cannot_be_written_is_an_error_that_names_it(results: Results, tmp_path: Path) -> None:
    nothing = replace(results, outcomes=(), failures=(), rows=(), sensing=(), sweep=(), pressure=(), observer=())
    assert write_report(nothing, tmp_path / "new" / "folder").read_text().startswith("<!doctype html>")
    (tmp_path / "file").write_text("")
    with pytest.raises(TendrilError, match="file"):
        write_report(nothing, tmp_path / "file" / "report")
