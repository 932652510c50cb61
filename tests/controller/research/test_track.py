"""Any path through the real tick on the twin."""

import json
from pathlib import Path

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.controllers.registry import with_controller
from controller.reference.drawn import Wish
from controller.reference.library import reference
from controller.research.experiments.plant_scale import scaled
from controller.research.track import TrackTask, figures, track
from controller.schema.actuator import PRESETS
from controller.schema.parameters import REPEATING, TwinParameters
from controller.simulation.case import Case, Setup, run_case
from controller.simulation.metrics import UNITS, Window

pytestmark = pytest.mark.keyed()

P1 = PRESETS["P1"]
TIME = np.arange(0.0, 6.0, 1e-3)
ROW = {
    "experiment",
    "actuator",
    "law",
    "metric",
    "unit",
    "paper",
    "paper_low",
    "paper_high",
    "ours",
    "ours_std",
    "role",
}


def written(folder: Path, p: Array, dt: float = 1e-3) -> Path:
    file = folder / "spiral.csv"
    file.write_text("t,x,y\n" + "".join(f"{i * dt!r},{x!r},{y!r}\n" for i, (x, y) in enumerate(p.tolist())))
    return file


def circle(frequency: float, seconds: float, radius: float = 0.03) -> Array:
    angle = 2.0 * np.pi * frequency * np.arange(0.0, seconds, 1e-3)
    return np.column_stack([0.03 + radius * np.cos(angle), 0.14 + radius * np.sin(angle)])


@pytest.fixture
def library_circle(tmp_path: Path) -> Path:
    planned = reference("circle_1hz", P1)
    return written(tmp_path, planned.p[planned.start :])


def test_the_library_s_circle_from_a_file_gives_the_library_s_metrics_to_the_last_bit(library_circle: Path) -> None:
    known = run_case(Case("circle_1hz", seed=5), Setup())
    found = track(TrackTask(library_circle, P1, seed=5))
    assert found.windows == known.metrics
    assert found.window is Window.WHOLE
    assert found.reference.frequency == 1.0 and found.reference.velocity_feedforward


@pytest.mark.parametrize(
    ("name", "actuator", "law"), [("circle_1hz", "P1", "ff+pi"), ("step", "P2", "ff"), ("digit_8", "P3", "rod6")]
)
@pytest.mark.parametrize("begin", [0, 2000])
def test_the_metrics_of_the_library_come_out_to_the_bit_with_either_approach(
    tmp_path: Path, name: str, actuator: str, law: str, begin: int
) -> None:
    known = run_case(Case(name, actuator, law, seed=3), Setup())
    found = track(TrackTask(written(tmp_path, known.reference.p[begin:]), PRESETS[actuator], law, seed=3))
    assert found.windows == known.metrics
    assert found.reference.approach == known.reference.start * 1e-3
    assert found.reference.own_approach == pytest.approx(known.reference.start * 1e-3 - begin * 1e-3)
    assert found.reference.steps == len(known.reference.steps)


def test_a_file_with_six_decimals_is_measured_like_the_library(tmp_path: Path) -> None:
    known = run_case(Case("step", law="ff"), Setup())
    found = track(TrackTask(written(tmp_path, known.reference.p.round(6)), P1, "ff"))
    for window, metrics in known.metrics.items():
        assert found.windows[window] == pytest.approx(metrics, rel=0.05)


def test_each_axis_of_an_eight_lags_at_its_own_frequency(tmp_path: Path) -> None:
    eight = 0.03 * np.column_stack([np.sin(2 * np.pi * 0.5 * TIME), np.sin(2 * np.pi * TIME)]) + [0.03, 0.14]
    slow = track(TrackTask(written(tmp_path, eight), P1, setup=Setup(twin=scaled(TwinParameters(), "delay=0.02"))))
    plain = track(TrackTask(written(tmp_path, eight), P1))
    assert plain.reference.axis_frequencies == (0.5, 1.0)
    assert plain.reference.velocity_feedforward
    for axis, frequency in (("x", 0.5), ("y", 1.0)):
        later = slow.windows[Window.WHOLE][f"lag_deg_{axis}"] - plain.windows[Window.WHOLE][f"lag_deg_{axis}"]
        assert 0.3 * 360 * frequency * 0.02 < later < 3.0 * 360 * frequency * 0.02


def test_steps_that_repeat_have_no_velocity_feedforward_unless_it_is_asked_for(tmp_path: Path) -> None:
    corners = 0.03 + 0.02 * np.sign(circle(0.5, 8.0) - [0.03, 0.14] + 1e-9) + [0.0, 0.11]
    file = written(tmp_path, corners)
    found = track(TrackTask(file, P1))
    assert found.reference.steps > 5 and not found.reference.velocity_feedforward
    assert found.window is Window.AFTER_APPROACH and "sse" in found.windows[found.window]
    asked = track(TrackTask(file, P1, wish=Wish(velocity_feedforward=True, frequency=0.5)))
    assert asked.reference.velocity_feedforward and "lag_deg_x" in asked.windows[Window.WHOLE]


def test_the_figures_have_the_reproduction_s_rows_and_facts_of_path_and_twin(library_circle: Path) -> None:
    twin = scaled(TwinParameters(), "k=1.1,delay=0.01")
    found = track(TrackTask(library_circle, P1, "ff", 2, setup=Setup(twin=twin)))
    told = json.loads(json.dumps(figures(found), allow_nan=False))
    assert {row["metric"] for row in told["rows"]} == set(UNITS) - {"sse", "step_spread", "reduction"}
    for row in told["rows"]:
        assert ROW <= set(row)
        assert (row["experiment"], row["actuator"], row["law"], row["paper"]) == ("spiral", "P1", "ff", None)
        assert row["role"] == "paper gives none" and row["ours_std"] is None
        assert row["ours"] == told["windows"]["whole run"][row["metric"]]
        assert row["ours_other_window"] == told["windows"]["after the approach"][row["metric"]]
    assert told["twin"]["dead_time"] == pytest.approx(TwinParameters().dead_time + 0.01)
    assert told["twin"]["seed"] == 2
    about = told["reference"]
    assert about["duration"] == pytest.approx(7.0) and about["approach"] == 2.0 and about["own_approach"] == 0.0
    assert about["length"] == pytest.approx(7 * np.pi * 0.06, rel=1e-3)
    assert about["peak_speed"] == pytest.approx(np.pi * 0.06, rel=1e-3)
    assert about["off_path_seconds"] == 0.0 and about["branch_changes"] == []


def test_another_plant_is_followed_otherwise_but_the_reference_stays(library_circle: Path) -> None:
    plain, slow = (
        track(TrackTask(library_circle, P1, setup=Setup(twin=scaled(TwinParameters(), text))))
        for text in ("", "delay=0.02")
    )
    assert slow.reference.length == plain.reference.length
    assert slow.windows[Window.WHOLE]["rmse"] != plain.windows[Window.WHOLE]["rmse"]


def test_a_path_without_a_period_is_judged_after_the_approach_and_has_no_phase(tmp_path: Path) -> None:
    found = track(TrackTask(written(tmp_path, circle(0.5, 1.0)), P1))
    assert found.window is Window.AFTER_APPROACH
    assert not found.reference.velocity_feedforward
    assert not any(metric.startswith("lag") for metric in found.windows[found.window])


def test_a_path_that_jumps_is_run_to_its_end(tmp_path: Path) -> None:
    corners = 0.03 + 0.02 * np.sign(circle(0.5, 4.0) - [0.03, 0.14] + 1e-9) + [0.0, 0.11]
    last = np.vstack([np.tile([0.03, 0.14], (2000, 1)), [0.03, 0.17]])
    assert track(TrackTask(written(tmp_path, last), P1)).reference.duration == 0.0
    found = track(TrackTask(written(tmp_path, corners), P1))
    assert not found.failed
    assert found.windows[Window.WHOLE]["max_x"] > 20.0


def test_a_projected_path_is_judged_by_the_nearest_points_within_reach(tmp_path: Path) -> None:
    away = np.column_stack([np.linspace(0.1, 0.3, 4000), np.full(4000, 0.14)])
    found = track(TrackTask(written(tmp_path, away), P1, wish=Wish(project=True)))
    assert 0.3 < found.reference.projected_share < 0.7
    assert found.reference.projected_most > 30e-3
    assert found.windows[Window.AFTER_APPROACH]["rmse"] < 30.0


def test_a_run_that_the_rig_breaks_off_says_when_and_why_and_has_no_numbers(tmp_path: Path) -> None:
    weak = Setup(twin=TwinParameters(stiffness_scale=2.0, torque_gain=(0.5, 0.5)))
    found = track(TrackTask(written(tmp_path, circle(1.0, 8.0, 0.05)), P1, law="ff+p", setup=weak))
    assert found.windows == {}
    told = figures(found)
    assert "spiral: FAULT (TRACKING_ERROR) after" in told["failed"] and "approach of 2 s included" in told["failed"]
    assert {row["metric"] for row in told["rows"]} >= {"rmse", "max_x", "lag_deg_x"}
    assert all(row["ours"] is None and row["ours_other_window"] is None for row in told["rows"])
    assert told["reference"]["off_path_seconds"] is None


def test_another_controller_follows_the_same_path_better(library_circle: Path) -> None:
    found = {}
    for name in ("paper", "preview"):
        tracked = track(TrackTask(library_circle, P1, setup=Setup(gains=with_controller(REPEATING, name))))
        found[name] = tracked.windows[Window.AFTER_APPROACH]["rmse"]
        assert figures(tracked)["controller"] == name
    assert found["preview"] < 0.45 * found["paper"]
