"""The paper's numbers, transcribed twice: here the tables as the paper prints them."""

import math
from collections import Counter

import numpy as np
import pytest

from controller.errors import DataError
from controller.reference.library import SWEEP, names
from controller.reference.reference import Reference
from controller.research.experiments.paper_rows import (
    BESIDE,
    DIGITS,
    EXPERIMENTS,
    FITTED,
    JUDGED,
    PAPER_ROWS,
    SEEN,
    STEP_TABLE,
    paper_row,
    window_of,
)
from controller.simulation.metrics import UNITS, Window, errors
from controller.system.origin import ROOT

pytestmark = pytest.mark.keyed("docs/conventions.md")

STEP_LATEX = r"""
FF & 30.5 & 15.7 & 3309 \\ \hline
FF+P & 23.8 & 11.3 & 2007 \\ \hline
FF+I & 19.1 & 1.0 & 1131 \\ \hline
FF+PI & 14.4 & 1.0 & 625 \\
"""
TASKS_LATEX = r"""
1 & Digits & 30 & 10 s & 1.5-2.3 \\
1 & VU & 50 & 25 s & 1.9 \\
2 & Vertical line & 60 & 0.25 Hz & 7.4 \\
& & & 1 Hz & 8.8 \\
2 & Horizontal line & 60 & 0.25 Hz & 9.2 \\
 &  & & 1 Hz & 12.4 \\
2 & Circle & 60 & 1 Hz & 7.4 \\
"""
TASKS = (
    *("digits", "vu", "vertical_0.25hz", "vertical_1hz"),
    *("horizontal_0.25hz", "horizontal_1hz", "circle_1hz"),
)


def cells(latex: str) -> list[list[str]]:
    return [[cell.strip() for cell in line.split(r"\\")[0].split("&")] for line in latex.strip().splitlines()]


def test_the_steps_are_those_of_the_paper_table() -> None:
    for law, *printed in cells(STEP_LATEX):
        rows = [paper_row("step", "P1", law.lower(), metric) for metric in ("rmse", "sse", "ise")]
        assert [found.paper for found in rows] == [float(number) for number in printed]
        assert [found.role for found in rows] == ["fit", "fit", "consulted"]


def test_tasks_1_and_2_are_those_of_the_paper_table() -> None:
    for experiment, (*_, printed) in zip(TASKS, cells(TASKS_LATEX), strict=True):
        found = paper_row(experiment, "P1", "ff+pi", "rmse")
        bounds = [float(number) for number in printed.split("-")]
        assert found.paper == pytest.approx(sum(bounds) / len(bounds))
        assert [found.paper_low, found.paper_high] == (bounds if len(bounds) == 2 else [None, None])


def test_task_3_is_what_the_text_says() -> None:
    said = {("P2", "vu"): 3.7, ("P2", "circle_1hz"): 9.1, ("P3", "vu"): 2.6, ("P3", "circle_1hz"): 5.5}
    said |= {("P3", "circle_2hz"): 11.4}
    for (actuator, experiment), number in said.items():
        assert paper_row(experiment, actuator, "ff+pi", "rmse").paper == number
    assert paper_row("circle_2hz", "P3", "ff+pi", "lag_deg_x").paper == 27.0


def test_the_paper_ise_is_no_less_than_its_mean_rmse_squared_times_three_seconds() -> None:
    """Jensen, up to the rounding of the RMSE: a wrong digit in either column would show."""
    for rmse, _, ise in STEP_TABLE.values():
        assert 3.0 * (rmse - 0.05) ** 2 <= ise < 1.25 * 3.0 * rmse**2


def test_nineteen_rows_are_fitted_ten_were_consulted_and_three_are_judged() -> None:
    kinds = Counter(row.metric for row in FITTED)
    assert kinds == {"rmse": 8, "sse": 4, "step_spread": 4, "reduction": 3} and {row.role for row in FITTED} == {"fit"}
    assert len(JUDGED) == 3 and {row.role for row in JUDGED} == {"held-out"}
    assert len(SEEN) == 6 and len(BESIDE) == 4 and {row.role for row in (*SEEN, *BESIDE)} == {"consulted"}
    assert {row.actuator for row in FITTED} == {"P1"}
    assert {row.metric for row in BESIDE} == {"ise"}


def test_the_spread_over_the_corners_is_what_ise_says_beyond_rmse() -> None:
    """The issue's numbers, by hand from the table; and a run's own spread is that of its four RMSE."""
    found = [paper_row("step", "P1", law, "step_spread").paper for law in STEP_TABLE]
    assert found == pytest.approx([13.1, 10.1, 3.5, 1.0], abs=0.05)
    e = np.repeat([1.0, 2.0, 4.0, 5.0], 3000)[:, None] * [0.6e-3, 0.8e-3]
    ours = errors(e, Reference("", e, 0, steps=(0, 3000, 6000, 9000)), Window.AFTER_APPROACH)
    assert ours["step_spread"] == pytest.approx(np.std([1e-3, 2e-3, 4e-3, 5e-3]))
    assert ours["step_spread"] == pytest.approx((ours["ise"] / 3.0 - ours["rmse"] ** 2) ** 0.5)


def test_task_4_is_fitted_by_what_rod_6_takes_off_ff() -> None:
    names = ("sensing_sweep", "sensing_circle", "sensing_vertical")
    assert [paper_row(name, "P1", "rod6", "reduction").paper for name in names] == [27.0, 74.0, 34.0]


def test_the_conventions_name_every_row_with_its_role() -> None:
    """docs/conventions.md was written first: what the code does is held to it."""
    lines = (ROOT / "docs" / "conventions.md").read_text().splitlines()
    for role, rows in (("fit", FITTED), ("consulted", (*SEEN, *BESIDE)), ("held-out", JUDGED)):
        [said] = [line for line in lines if line.startswith(f"| `{role}` | ")]
        assert {row.experiment for row in rows} == {name for name in SAID if SAID[name] in said.lower()}, role


SAID = {
    "step": "steps",
    "vu": "vu",
    "circle_1hz": "circle at 1 hz",
    "circle_2hz": "circle at 2 hz",
    "vertical_0.25hz": "lines at 0.25 hz",
    "horizontal_0.25hz": "lines at 0.25 hz",
    "vertical_1hz": "lines at 1 hz",
    "horizontal_1hz": "lines at 1 hz",
    "digits": "digits",
    "sensing_sweep": "sweep",
    "sensing_circle": "slow circle",
    "sensing_vertical": "slow vertical",
}
"""What the page calls an experiment."""


def test_a_row_has_a_role_if_and_only_if_the_paper_gives_a_number() -> None:
    assert len({row.key for row in PAPER_ROWS}) == len(PAPER_ROWS)
    for row in PAPER_ROWS:
        assert (row.paper is None) == (row.role == "paper gives none")
        assert row.experiment in EXPERIMENTS and row.unit == UNITS[row.metric][0]
        assert (row.paper_low or 0.0) <= (row.paper or row.paper_low or 0.0) <= (row.paper_high or math.inf)


def test_digits_have_bounds_but_no_number_of_their_own() -> None:
    for digit in DIGITS:
        found = paper_row(digit, "P1", "ff+pi", "rmse")
        assert (found.paper, found.paper_low, found.paper_high) == (None, 1.5, 2.3)


def test_where_the_paper_says_nothing_the_row_says_so() -> None:
    found = paper_row("sensing_circle", "P1", "rod6+10", "rmse")
    assert (found.paper, found.unit, found.role) == (None, "mm", "paper gives none")


@pytest.mark.parametrize("what", ["spiral P1 ff rmse", "vu P4 ff rmse", "vu P1 rod6 rmse", "vu P1 ff median"])
def test_a_name_that_no_row_has_is_refused(what: str) -> None:
    with pytest.raises(DataError, match="is none of"):
        paper_row(*what.split())


def test_only_periodic_tasks_and_live_paths_count_the_approach() -> None:
    assert window_of("circle_2hz") is window_of("sensing_vertical") is window_of("live_path") is Window.WHOLE
    assert window_of("vu") is window_of("digit_3") is window_of("step") is Window.AFTER_APPROACH
    assert window_of("frequency_sweep") is Window.AFTER_APPROACH
    with pytest.raises(DataError, match="spiral is none of"):
        window_of("spiral")


def test_every_reference_of_the_library_belongs_to_an_experiment() -> None:
    parts = {"digits", "live_path", "frequency_sweep"}
    assert (set(names()) - SWEEP.keys()) | parts == set(EXPERIMENTS)
