"""The observer with other gains: what the table says is what the runs say."""

from controller.experiments.case import Case, Setup, run_case
from controller.experiments.metrics import Window
from controller.experiments.observer_gains import observer_rmse, tried


def test_a_carried_marker_and_a_stiffer_spring_bring_the_observer_nearer() -> None:
    held, carried, stiff = (
        tried(Setup(), 0, *gains) for gains in ((100.0, 0.0, False), (100.0, 0.0, True), (400.0, 0.0, True))
    )
    for name, error in carried.observer_rmse.items():
        assert stiff.observer_rmse[name] < error < held.observer_rmse[name]


def test_with_the_paper_s_gains_it_is_the_reproduction_s_own_number() -> None:
    rmse = run_case(Case("circle_1hz"), Setup()).metrics[Window.WHOLE]["observer_rmse"]
    assert observer_rmse(Setup(), Case("circle_1hz")) == rmse
