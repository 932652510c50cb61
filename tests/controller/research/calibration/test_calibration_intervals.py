"""What an interval is made of: near-equal fits, other prints and the discrepancy. The numbers are made up."""

import math
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from controller.research.calibration.predictions import cases_of, predicted, row_residual
from controller.research.calibration.prints import another_print, is_flaw
from controller.research.calibration.problem import Evaluation, Problem
from controller.research.calibration.scales import SCALES, Scale, scale_of
from controller.research.calibration.space import Space, space_of
from controller.research.calibration.spread import (
    PRINTS,
    RowSpread,
    coverage,
    discrepancy,
    intervals,
    predictions,
    row_spread,
)
from controller.research.experiments.paper_rows import FITTED, JUDGED, PREDICTED, PaperRow
from controller.research.experiments.pool import Pool
from controller.schema.parameters import PlantKind, TwinParameters
from controller.simulation.case import Case

pytestmark = pytest.mark.keyed()

RMSE = FITTED[0]
SPREAD = next(row for row in FITTED if row.metric == "step_spread" and row.law == "ff")
REDUCTION = next(row for row in FITTED if row.metric == "reduction")
Z = Space().prior_point()


def fit(z: np.ndarray, numbers: list[float]) -> Evaluation:
    return Evaluation(z, tuple((number, 1.0) for number in numbers), (), np.zeros(1))


def test_a_reduction_is_what_rod_6_takes_off_ff_in_points_and_costs_by_points() -> None:
    ff, rod6 = cases_of(REDUCTION, 3)
    assert (ff, rod6) == (Case("sensing_sweep", "P1", "ff", 3), Case("sensing_sweep", "P1", "rod6", 3))
    assert predicted(REDUCTION, [({"rmse": 20.0}, 1.0), ({"rmse": 5.0}, 1.0)]) == (pytest.approx(75.0), 1.0)
    assert math.isnan(predicted(REDUCTION, [({"rmse": 20.0}, 1.0), ({}, 0.4)])[0])
    assert row_residual(REDUCTION, (27.0 + 15.0, 1.0)) == pytest.approx(1.5)
    assert row_residual(REDUCTION, (-3.0, 1.0)) == pytest.approx(-3.0)  # worse than FF is a number, too


def test_a_spread_of_the_steps_costs_as_an_sse_does() -> None:
    assert SPREAD.paper is not None
    assert row_residual(SPREAD, (SPREAD.paper, 1.0)) == 0.0
    assert row_residual(SPREAD, (9.0, 1.0)) == pytest.approx(math.log(10.0 / (SPREAD.paper + 1.0)) / 0.3)
    assert math.isfinite(row_residual(SPREAD, (0.0, 1.0)))


@pytest.mark.parametrize("scale", [Scale(0.1), *SCALES.values()])
def test_a_number_comes_back_from_its_place(scale: Scale) -> None:
    numbers = np.array([0.5, 3.0, 40.0])
    assert scale.numbers(scale.place(numbers)) == pytest.approx(numbers)


@pytest.mark.parametrize("plant", ["rod", "cosserat"])
def test_another_print_has_flaws_of_its_own_and_the_rest_of_the_fit(plant: PlantKind) -> None:
    space = space_of(plant)
    z = np.random.default_rng(1).uniform(size=len(space.unknowns))
    one, again, other = (another_print(space, z, seed) for seed in ((0, 1, 2), (0, 1, 2), (0, 1, 3)))
    changed = {space.unknowns[i].name.removeprefix("cosserat.") for i in np.flatnonzero(one != z)}
    fields = "torque_gain", "chamber_imbalance", "set_curvature"
    assert changed == {f"{name}.{j}" for name in fields for j in (0, 1)} and (one == again).all()
    assert ((one != other) == [is_flaw(unknown) for unknown in space.unknowns]).all()
    space.decode(one)  # within the bounds


def test_prints_are_spread_as_their_priors_are() -> None:
    space = Space()
    i = next(i for i, one in enumerate(space.unknowns) if one.name == "chamber_imbalance.1")
    drawn = [space.unknowns[i].value(another_print(space, Z, (0, n))[i]) for n in range(400)]
    assert np.mean(drawn) == pytest.approx(0.0, abs=0.02) and np.std(drawn) == pytest.approx(0.1, rel=0.15)


def test_p1_is_predicted_by_the_fits_themselves_and_every_other_row_by_other_prints_too() -> None:
    problem, fits = Problem(), [fit(Z, []), fit(np.full(len(Z), 0.4), [])]
    calls = predictions(problem, fits)
    assert [rows for rows, *_ in calls[:2]] == [tuple(row for row in PREDICTED if row.actuator == "P1")] * 2
    twins = {name: [setup.twin for rows, setup, _ in calls if rows[0].actuator == name] for name in ("P1", "P2", "P3")}
    own = [problem.space.decode(one.z).twin for one in fits]
    assert twins["P1"] == own
    assert repr(predictions(problem, fits)) == repr(calls)  # drawn by the seed
    for name in ("P2", "P3"):
        best, *drawn = twins[name]
        assert best == own[0] and len(drawn) == PRINTS * len(fits)
        assert len({twin.chamber_imbalance for twin in drawn}) == len(drawn)
        assert [twin.kappa for twin in drawn] == [twin.kappa for twin in own for _ in range(PRINTS)]
    assert not {flaws(twin) for twin in twins["P2"][1:]} & {flaws(twin) for twin in twins["P3"][1:]}


def flaws(twin: TwinParameters) -> tuple[tuple[float, float], ...]:
    return twin.torque_gain, twin.chamber_imbalance, twin.set_curvature


def test_the_discrepancy_is_what_the_fits_do_not_explain() -> None:
    rows = [replace(RMSE, paper=10.0), replace(RMSE, law="ff+p", paper=10.0)]
    far, near = 10.0 * math.exp(0.2), 10.0 * math.exp(-0.2)  # two deviations
    assert discrepancy(rows, [fit(Z, [far, near])]) == pytest.approx(2.0)
    about = [fit(Z, [far * math.exp(d), near * math.exp(d)]) for d in (-0.1, 0.1)]  # the fits explain one of them
    assert discrepancy(rows, about) == pytest.approx(3.0**0.5)
    wide = [fit(Z, [10.0 * math.exp(d)] * 2) for d in (-0.3, 0.3)]
    assert discrepancy(rows, wide) == 0.0
    assert discrepancy(rows, [fit(Z, [math.nan, far])]) == pytest.approx(2.0)


def test_a_discrepancy_widens_every_interval_by_its_factor_or_its_points() -> None:
    numbers = np.array([10.0, 9.0, 11.0])
    narrow, wide = row_spread(RMSE, numbers, 0.0), row_spread(RMSE, numbers, 2.0)
    assert (narrow.low, narrow.high) == pytest.approx((9.0, 11.0))
    assert wide.low < narrow.low and wide.high > narrow.high and wide.median == pytest.approx(10.0, rel=0.01)
    alone = row_spread(RMSE, np.array([10.0]), 2.0)
    assert (alone.low, alone.high) == pytest.approx((10.0 * math.exp(-0.329), 10.0 * math.exp(0.329)), rel=0.01)
    points = row_spread(REDUCTION, np.array([40.0]), 1.0)
    assert (points.low, points.high) == pytest.approx((40.0 - 16.4, 40.0 + 16.4), abs=0.4)
    assert row_spread(SPREAD, np.array([0.5]), 3.0).low == 0.0


def test_coverage_counts_fit_rows_alone() -> None:
    held = RowSpread(JUDGED[0], 1.9, 0.0, 1.0, 9.0, 2)
    spread = [RowSpread(row, 1.0, low, 1.0, 1e6, 2) for row, low in zip(FITTED, (0.0, 0.0, 1e5), strict=False)]
    assert coverage([*spread, held]) == (2, 3)


class Told:
    """A pool that runs nothing: every row comes out as the paper has it, or one more."""

    def map(self, work: Any, calls: list[tuple[tuple[PaperRow, ...], Any, int]], done: Any) -> list[Any]:
        found = [[((row.paper or 0.0) + (i > 0), 1.0) for row in rows] for i, (rows, *_) in enumerate(calls)]
        for one in found:
            done(one)
        return found


def test_every_row_has_one_interval_the_best_fit_first() -> None:
    seen: list[Any] = []
    problem = Problem()
    fits = [fit(Z, [share * (row.paper or 0.0) for row in FITTED]) for share in (0.9, 1.1)]
    found = intervals(problem, fits, cast(Pool, Told()), seen.append)
    assert [one.row for one in found] == [*FITTED, *PREDICTED] and len(seen) == len(predictions(problem, fits))
    assert coverage(found) == (19, 19)
    by_row = {one.row: one for one in found}
    assert by_row[JUDGED[0]].best == JUDGED[0].paper and by_row[JUDGED[0]].numbers == 2
    assert by_row[JUDGED[1]].numbers == 1 + 2 * PRINTS
    assert scale_of("rmse") == Scale(0.1)
