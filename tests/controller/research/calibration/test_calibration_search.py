"""The search on a small problem whose answer is known: the "paper" is the twin with two other numbers."""

from collections import Counter
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from controller.research.calibration.ensemble import FITS_MIN, WALKERS, Ensemble, reflected, walk
from controller.research.calibration.evolve import BROKEN_MARGIN, MEMBERS, evolve, guarded
from controller.research.calibration.margins import Margin, Trial
from controller.research.calibration.predictions import predict
from controller.research.calibration.problem import Evaluation, Problem, evaluate, keeps_margins
from controller.research.calibration.search import QUICK, Effort, Search, apart, effort_of, ending, neighbours
from controller.research.calibration.space import Space
from controller.research.calibration.unknowns import Unknown
from controller.research.experiments.paper_rows import FITTED
from controller.research.experiments.pool import OutOfTime, Pool, WorkerDied

pytestmark = pytest.mark.keyed()

UNKNOWNS = (
    Unknown("torque_gain.0", 0.9, 1.3, 1.05, 5.0),
    Unknown("K_P", 0.1, 0.4, 0.15, 5.0, log=True),
)
TRUTH = np.array([0.6, 0.7])
SPACE = Space(UNKNOWNS)
SMALL = Effort(screen=4, starts=1, steps=6, minutes=3.0)


@pytest.fixture(scope="module")
def problem() -> Problem:
    """The step rows of FF and FF+P, as the twin has them at TRUTH."""
    rows = [row for row in FITTED if row.experiment == "step" and row.law in ("ff", "ff+p")]
    ours = predict(rows, SPACE.decode(TRUTH))
    return Problem(SPACE, tuple(replace(row, paper=number) for row, (number, _) in zip(rows, ours, strict=True)), ())


def evaluation(z: list[float], cost: float) -> Evaluation:
    return Evaluation(np.array(z), (), (), np.array([np.sqrt(2.0 * cost)]))


def test_known_numbers_are_found_again(problem: Problem) -> None:
    told: Counter[str] = Counter()
    with Pool(1) as pool:
        search = Search(problem, pool, SMALL, lambda stage, best: told.update([stage.name]))
        assert ending(lambda: search.run(seed=0)) == "finished"
    best = search.best()
    assert best is not None and best.cost < 0.1 and best.cost == search.best_cost
    values, truth = SPACE.values(best.z), SPACE.values(TRUTH)
    assert {name: values[name] / truth[name] for name in values} == pytest.approx(dict.fromkeys(values, 1.0), abs=0.1)
    assert told["screening"] == 4 and told["start 1"] == len(search.found) - 4


@pytest.mark.process
def test_any_number_of_processes_gives_the_same_bits_and_time_ends_it(problem: Problem) -> None:
    points = SPACE.draw(3, seed=4)
    with Pool(2) as pool:
        found = pool.map(evaluate, [(problem, z) for z in points])
        with pytest.raises(OutOfTime):
            pool.map(evaluate, [(problem, z) for z in points], over=lambda: True)
        spent = Search(problem, pool, replace(SMALL, minutes=0.0))
        assert ending(lambda: spent.run(seed=0)) == "out of time" and spent.best() is None
    for one, z in zip(found, points, strict=True):
        assert one.residuals.tobytes() == evaluate(problem, z).residuals.tobytes()


def test_a_hopeless_point_is_not_asked_for_its_margins(problem: Problem) -> None:
    guarded = replace(problem, trials=(Trial("P1", "stop", "gain"),))
    found = evaluate(guarded, np.array([0.0, 0.0]), hopeless=0.0)
    assert found.margins == () and not keeps_margins(guarded, found)
    assert len(found.residuals) == len(problem.rows) + len(UNKNOWNS)


def test_a_plant_that_cannot_be_run_is_a_bad_point_with_its_reason_and_not_the_end(problem: Problem) -> None:
    impossible = replace(problem.rows[0], experiment="no_such")
    found = evaluate(replace(problem, rows=(impossible,), trials=(Trial("P1", "stop", "gain"),)), TRUTH, hopeless=0.0)
    assert found.cost > 1e3 and "'no_such' is not one of" in found.trouble
    assert not keeps_margins(problem, found) and found.margins == ()


@pytest.mark.parametrize(
    ("error", "ended"),
    [(KeyboardInterrupt, "interrupted"), (WorkerDied, "a worker died"), (OutOfTime, "out of time")],
)
def test_what_cuts_a_search_short_is_told_and_loses_nothing(problem: Problem, error: type, ended: str) -> None:
    class Unlucky(Bowl):
        def map(self, work: Any, calls: list[Any], done: Any, over: Any) -> list[Evaluation]:
            super().map(work, calls[:2], done, over)
            raise error

    search = Search(problem, cast(Pool, Unlucky()), SMALL)
    assert ending(lambda: search.run(seed=0)) == ended and len(search.found) == 2


def test_quick_changes_only_what_is_not_given() -> None:
    assert effort_of(QUICK, screen=None, minutes=None) == QUICK
    assert effort_of(QUICK, screen=5, minutes=0.5) == replace(QUICK, screen=5, minutes=0.5)
    assert effort_of(Effort(), starts=3, rounds=None) == replace(Effort(), starts=3)


def test_differences_stay_in_the_box() -> None:
    points, steps = neighbours(np.array([0.0, 0.5, 1.0]))
    assert ((points >= 0.0) & (points <= 1.0)).all()
    assert np.diag(points) - np.array([0.0, 0.5, 1.0]) == pytest.approx(steps)


def test_starts_are_the_best_that_are_apart() -> None:
    ranked = [evaluation([0.5, 0.5], 1.0), evaluation([0.51, 0.5], 2.0), evaluation([0.9, 0.5], 3.0)]
    assert apart(ranked, 8, 0.1) == [ranked[0], ranked[2]]
    assert apart(ranked, 1, 0.0) == ranked[:1]


class Bowl:
    """A pool whose every cost is a bowl about the middle of the box, so that the walk can be looked at alone."""

    def map(self, work: Any, calls: list[Any], done: Any, over: Any) -> list[Evaluation]:
        found = [Evaluation(z, (), (), np.sqrt(80.0) * (z - 0.5)) for _, z, _ in calls]
        for one in found:
            done(one)
        return found


def test_the_walkers_come_to_lie_as_what_they_cost_says_and_do_the_same_again(problem: Problem) -> None:
    """exp(-cost) of the bowl is a normal distribution: its deviation along each axis is the root of 1/80."""
    middle = np.full(2, 0.5)
    best, runs = Evaluation(middle, (), (), 0.0 * middle), []
    for _ in range(2):
        search, ensemble = Search(problem, cast(Pool, Bowl()), SMALL, found=[best]), Ensemble()
        walk(search, ensemble, seed=1)
        runs.append(ensemble.fits(best))
    places = np.array([one.z for one in ensemble.walkers])
    assert len(ensemble.walkers) == WALKERS >= FITS_MIN and ensemble.rounds == SMALL.rounds
    assert places.std(axis=0) == pytest.approx(np.full(2, 80.0**-0.5), rel=0.4)
    assert places.mean(axis=0) == pytest.approx(np.full(2, 0.5), abs=0.1)
    assert 0.15 < ensemble.accepted / ensemble.tried < 0.85
    assert runs[0][0] is best and [one.z.tobytes() for one in runs[0]] == [one.z.tobytes() for one in runs[1]]


def test_a_step_beyond_a_wall_is_thrown_back() -> None:
    assert reflected(np.array([-0.2, 0.3, 1.2, 2.1])) == pytest.approx([0.2, 0.3, 0.8, 0.1])


def test_the_evolution_goes_on_from_the_best_points_and_does_the_same_again(problem: Problem) -> None:
    firsts = [evaluation([x, 0.9], 40.0 * ((x - 0.5) ** 2 + 0.16)) for x in (0.1, 0.2, 0.9)]
    runs = []
    for _ in range(2):
        search = Search(problem, cast(Pool, Bowl()), replace(SMALL, generations=8), found=list(firsts))
        evolve(search, seed=1)
        runs.append(search.found)
    assert search.best_cost < 0.05 * min(one.cost for one in firsts)
    assert len(search.found) == len(firsts) + MEMBERS * 8
    assert [one.z.tobytes() for one in runs[0]] == [one.z.tobytes() for one in runs[1]]


def test_the_evolution_shuns_points_that_do_not_keep_the_margins(problem: Problem) -> None:
    bound = replace(problem, trials=(Trial("P1", "stop", "gain"),))
    kept, lost = (Margin(bound.trials[0], swing, 1.0, 1.0) for swing in (1e-3, 5e-3))
    point = evaluation([0.5, 0.5], 1.0)
    costs = [guarded(bound, replace(point, margins=margins)) for margins in ((kept,), (lost,), ())]
    assert costs == pytest.approx([1.0, 1.0 + BROKEN_MARGIN, 1.0 + BROKEN_MARGIN])
