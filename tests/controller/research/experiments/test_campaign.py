"""Runs over processes: the same bits in the same order, a failure among them, and what a worker keeps."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import pytest

from controller.errors import ParameterError, RecordingError
from controller.research.experiments.campaign import Job, Keep, campaign
from controller.research.experiments.results import THINNED, Failure, Finished
from controller.simulation.case import Case, Outcome, Setup, run_case

pytestmark = pytest.mark.keyed()

QUICK = Case("circle_2hz", "P3")
CASES = (Case("circle_2hz", "P3", seed=1), Case("no_such"), QUICK, Case("circle_2hz", "P3", law="no_such"))


def note(folder: Path, outcome: Outcome) -> None:
    """What a worker keeps, in these tests: how many rows there were."""
    (folder / f"{outcome.case.law}_{outcome.case.seed}").write_text(str(len(outcome.rows)))


def refuse(outcome: Outcome) -> None:
    raise RecordingError("the disk is full")


def jobs(cases: Sequence[Case] = CASES, keep: Keep | None = None) -> list[Job]:
    return [Job(case, Setup(), keep) for case in cases]


@pytest.mark.process
def test_over_processes_as_alone_bit_for_bit_in_order_and_each_is_told_once(tmp_path: Path) -> None:
    told: list[Case] = []
    alone = campaign(jobs(), 1, told.append)
    side_by_side = campaign(jobs(keep=partial(note, tmp_path)), 2, told.append)
    assert sorted(map(str, told)) == sorted(map(str, 2 * CASES))
    assert [run.case for run in alone] == [run.case for run in side_by_side] == list(CASES)
    for one, other in zip(alone, side_by_side, strict=True):
        if isinstance(one, Failure):
            assert one == other
        else:
            assert isinstance(other, Finished)
            assert one.metrics == other.metrics
            assert one.trace.tip.tobytes() == other.trace.tip.tobytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ff+pi_0", "ff+pi_1"]


def test_a_case_that_cannot_be_run_is_a_failure_with_its_sentence() -> None:
    unknown, law = campaign(jobs((CASES[1], CASES[3])), 1, lambda case: None)
    assert isinstance(unknown, Failure) and "'no_such' is not one of step, digit_0" in unknown.sentence
    assert isinstance(law, Failure) and "law = 'no_such'" in law.sentence


def test_what_is_kept_of_a_run_is_its_telemetry_thinned() -> None:
    whole = run_case(QUICK, Setup())
    [kept] = campaign(jobs((QUICK,)), 1, lambda case: None)
    assert isinstance(kept, Finished)
    thin = whole.rows[::THINNED]
    assert kept.metrics == whole.metrics
    assert (kept.trace.p_hat == thin["p_hat"]).all() and (kept.trace.backbone == thin["backbone"]).all()
    assert kept.trace.t == pytest.approx((thin["t_ns"] - thin["t_ns"][0]) * 1e-9)
    assert (kept.trace.tip == kept.trace.twin_backbone[:, -1]).all()


def test_a_run_that_cannot_be_kept_has_its_numbers_all_the_same() -> None:
    kept, lost = campaign([*jobs((QUICK,)), *jobs((QUICK,), refuse)], 1, lambda case: None)
    assert isinstance(kept, Finished) and isinstance(lost, Finished)
    assert (kept.unkept, lost.unkept, lost.metrics) == ("", "the disk is full", kept.metrics)


@pytest.mark.parametrize("workers", [0, -1, 257])
def test_an_impossible_number_of_workers_is_refused(workers: int) -> None:
    with pytest.raises(ParameterError, match=rf"workers = {workers} is outside \[1, 256\]"):
        campaign(jobs(), workers, lambda case: None)
