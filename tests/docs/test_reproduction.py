"""The published rows are what the code and the fits' files give: a stale table would promise what no one gets."""

import re

import pytest

from controller.research.experiments.fitted_intervals import intervals_of, paper_fit, paper_setup
from controller.research.experiments.paper_rows import PAPER_ROWS, paper_row, window_of
from controller.simulation.case import Case, run_case
from controller.system.origin import ROOT

pytestmark = pytest.mark.keyed("docs/reproduction.md")

PAGE = (ROOT / "docs" / "reproduction.md").read_text()
ROW = re.compile(
    r"^\| ([\w.]+), (P\d), ([\w+]+) \| (\w+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d. -]+) \| ([\w-]+) \|$", re.M
)
"""Experiment, actuator, law, metric, paper, ours, ratio, interval, role."""
COSSERAT_ROW = re.compile(
    r"^\| ([\w.]+), (P\d), ([\w+]+) \| (\w+) \| ([\d.]+) \| ([\d.]+) \| (-?[\d.]+) - ([\d.]+) \| ([\w-]+) \|$", re.M
)
"""Experiment, actuator, law, metric, paper, ours, both ends of the interval, role."""
COSSERAT_TABLE = {found[:4]: found[4:] for found in COSSERAT_ROW.findall(PAGE)}
TABLE = {found[:4]: found[4:] for found in ROW.findall(PAGE)}
CHEAP = (
    *("step P1 ff+pi rmse", "circle_1hz P1 ff+pi rmse", "vertical_0.25hz P1 ff+pi rmse"),
    *("circle_1hz P2 ff+pi rmse", "circle_2hz P3 ff+pi rmse", "circle_2hz P3 ff+pi lag_deg_x"),
)
"""Runs of 6 to 17 s, on all three actuators."""
COSSERAT = {
    (one["experiment"], one["actuator"], one["law"], one["metric"]): one for one in paper_fit("cosserat")["spread"]
}
SEEDS = 0.03
"""The table has the mean of three seeds, one of which is run here."""


def test_the_table_has_every_row_with_a_number_in_the_paper() -> None:
    wanted = {row.key: row for row in PAPER_ROWS if row.paper is not None}
    assert TABLE.keys() == intervals_of(paper_fit("rod")).keys() == wanted.keys()
    for key, (paper, ours, ratio, _, role) in TABLE.items():
        assert (float(paper), role) == (pytest.approx(wanted[key].paper, rel=0.005), wanted[key].role)
        assert float(ratio) == pytest.approx(float(ours) / float(paper), abs=0.006 + 0.01 * float(ratio))


def test_the_table_has_the_intervals_of_the_fit_file() -> None:
    intervals = intervals_of(paper_fit("rod"))
    for key, (_, _, _, interval, _) in TABLE.items():
        low, high = (float(end) for end in interval.split(" - "))
        assert [low, high] == pytest.approx(list(intervals[key]), rel=0.01, abs=1e-3)


def test_the_table_of_the_other_plant_has_the_intervals_of_its_fit_file() -> None:
    assert COSSERAT_TABLE.keys() == COSSERAT.keys() <= TABLE.keys()  # its search had fewer rows
    for key, (paper, _, *interval, role) in COSSERAT_TABLE.items():
        one = COSSERAT[key]
        assert role == one["role"]
        numbers = [float(number) for number in (paper, *interval)]
        assert numbers == pytest.approx([one["paper"], one["low"], one["high"]], rel=0.01)


@pytest.mark.parametrize("what", ["circle_1hz P1 ff+pi rmse", "circle_1hz P2 ff+pi rmse"])
def test_a_run_on_the_other_plant_gives_what_is_published(what: str) -> None:
    experiment, actuator, law, metric = what.split()
    found = run_case(Case(experiment, actuator, law), paper_setup("cosserat")).metrics[window_of(experiment)][metric]
    assert found == pytest.approx(float(COSSERAT_TABLE[experiment, actuator, law, metric][1]), rel=SEEDS)


@pytest.mark.parametrize("what", CHEAP)
def test_a_run_gives_what_is_published(what: str) -> None:
    experiment, actuator, law, metric = what.split()
    found = run_case(Case(experiment, actuator, law), paper_setup()).metrics[window_of(experiment)][metric]
    assert paper_row(experiment, actuator, law, metric).paper is not None
    assert found == pytest.approx(float(TABLE[experiment, actuator, law, metric][1]), rel=SEEDS)
