"""What the commissioning makes of measurements: frame, signs, drivers, pressures, decays, circle, report."""

import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from controller.errors import CommandRefused, ParameterError
from controller.schema.actuator import PRESETS
from controller.schema.commissioned import RESTS_ON
from controller.schema.hardware import Drivers, DriverStatus, MotionCapture, PressureLoop, Valves
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Law
from controller.schema.parameters import RigParameters, Settings
from controller.schema.rig_file import RigFile
from server.hardware.commissioning import closed_loop, drivers, identify, planning, pressure, report, sweep
from server.hardware.commissioning.messages import STEPS
from server.hardware.commissioning.planning import Circle, PressureFit, RawLoop
from server.hardware.commissioning.steps import ABOUT, lacking, resting_on
from server.hardware.commissioning.store import CommissioningStore, Kept, KeptResult, value_of
from server.hardware.first_mode.messages import Interval, MeasuredMode
from server.hardware.messages import RigFileState

RIG = RigParameters()


def driver(role: str, **changes: object) -> DriverStatus:
    plain = {
        "role": role, "driver": "natnet" if role == "motion_capture" else "serial", "device": "there",
        "state": "running", "detail": "", "capabilities": (), "rate": 200.0, "age": 0.004, "latency": 0.006,
        "clock": "two-way", "clock_offset": 1.5, "frames": 0, "lost": 0, "rejected": 0, "reconnects": 0, "values": {},
    }  # fmt: skip
    return DriverStatus.model_validate(plain | changes)


@pytest.mark.parametrize(
    "role, last, complaint",
    [
        ("valves", {"frames": 400}, ""),
        ("valves", {"frames": 400, "lost": 9}, "valves, loss is 0.022 1: at most 0.01"),
        ("motion_capture", {"frames": 400, "rate": 25.0}, "motion capture, rate is 25 1/s: at least 40 1/s"),
        ("motion_capture", {"frames": 400, "latency": 0.08}, "motion capture, latency is 0.08 s: at most 0.05 s"),
        ("motion_capture", {"frames": 400, "rejected": 400}, ""),  # strangers: markers of other things
        ("valves", {"state": "lost", "detail": "no such port"}, "valves (serial) is lost: no such port"),
    ],
)
def test_drivers_are_judged_by_rate_loss_latency_and_state(role: str, last: dict[str, object], complaint: str) -> None:
    other = "valves" if role == "motion_capture" else "motion_capture"
    first = Drivers(drivers=(driver(role), driver(other)))
    found = drivers.judged([first, Drivers(drivers=(driver(role, **last), driver(other, frames=400)))])
    assert found.good == (not complaint), found.text
    assert complaint in found.text


def fit(**changes: object) -> PressureFit:
    one = (0.05, 0.04, 0.06)
    plain = {"dead_time": one, "lag": one, "inflate": one, "exhaust": (0.1, 0.09, 0.11), "residual": 1e3}
    more = {"gains": (1.0,) * 4, "zeros": (0.0,) * 4, "curves": ()}
    return PressureFit(**(plain | more | changes))  # type: ignore[arg-type]


def test_dead_time_and_lag_are_written_where_the_chambers_follow() -> None:
    found = pressure.judged(fit(), 80e3)
    assert found.good and not found.again
    assert found.changes == {"controller.dead_time": 0.05, "controller.pneumatic_lag": 0.05, "valves.measured": True}
    loose = pressure.judged(fit(residual=1.2e4), 80e3)
    assert not loose.good and "residual is 1.2e+04 Pa: at most 9600 Pa" in loose.text
    weak = pressure.judged(fit(gains=(1.0, 0.8, 1.0, 1.0)), 80e3)
    assert not weak.good and "u1-, gain is 0.8 1: 1 within 0.15" in weak.text
    off = pressure.judged(fit(zeros=(0.0, 0.0, 6e3, 0.0)), 80e3)
    assert not off.good and "u2+, at zero is 6000 Pa: at most 5000 Pa" in off.text
    assert pressure.judged(fit(residual=4.5e3), 25e3).good  # a small step exhausts slowly


def raw(phase: float = 50.0, **changes: object) -> RawLoop:
    wanted = PressureLoop(inflate_gain=5e-6, exhaust_gain=1e-5, integral_time=0.2)
    plain = {"delay": 0.02, "fill": (5e6,) * 4, "exhaust": (1e6,) * 4, "wanted": wanted}
    return RawLoop(**(plain | {"phase": (phase, 60.0), "margin": (0.02, 0.03)} | changes))  # type: ignore[arg-type]


def test_raw_valves_get_their_loop_first_and_one_that_is_right_stays() -> None:
    found = pressure.proposed(raw())
    assert found.good and found.again and "answer after 20 ms" in found.text
    assert found.changes == {
        "valves.loop.inflate_gain": 5e-6,
        "valves.loop.exhaust_gain": 1e-5,
        "valves.loop.integral_time": 0.2,
    }
    wanted = raw().wanted
    assert pressure.same_loop(wanted, wanted)
    assert pressure.same_loop(wanted.model_copy(update={"inflate_gain": 5.7e-6}), wanted)
    assert not pressure.same_loop(wanted.model_copy(update={"integral_time": 0.3}), wanted)
    assert pressure.judged(fit(), 80e3, raw()).good
    swings = pressure.judged(fit(), 80e3, raw(phase=20.0))
    assert not swings.good and "phase margin is 20 deg: at least 40 deg" in swings.text


def test_pressures_that_are_off_come_with_advice() -> None:
    smart, openings = Valves(driver="serial"), Valves(driver="serial", command="opening")
    assert "divide the gains of valves.loop by 3" in pressure.advice("jog", Cause.PRESSURE_MISMATCH, openings)
    assert "Step by 25 kPa" in pressure.advice("pressure", Cause.PRESSURE_MISMATCH, smart)
    assert pressure.advice("jog", Cause.PRESSURE_MISMATCH, smart) == ""
    assert pressure.advice("pressure", Cause.PRESSURE, openings) == ""


def test_steps_of_pressure_beyond_half_of_full_are_refused_with_both_numbers() -> None:
    assert pressure.step_pressure(None, RIG) == 80e3
    with pytest.raises(ParameterError, match="pressure = 150000 Pa is above 120648 Pa, half of full torque's"):
        pressure.step_pressure(150e3, RIG)


def test_the_sweep_stays_within_its_share_of_the_admissible_torques_and_makes_small_ways() -> None:
    for actuator in PRESETS.values():
        rig = RigParameters(actuator=actuator)
        torques = np.array(planning.sweep_torques(rig, 5, 0.7))
        assert len(torques) >= 9 and np.abs(torques).max() <= 0.7 * actuator.u_max + 1e-12
        assert np.abs(np.diff(torques, axis=0)).max() <= 4 * 0.35 * actuator.u_max
        for u in planning.release_torques(rig, 0.7, 2):
            assert max(map(abs, u)) <= 0.7 * actuator.u_max + 1e-12


def test_the_first_circle_is_slow_small_and_begins_in_its_middle() -> None:
    circle = planning.small_circle(RIG)
    assert circle.radius < 0.02 and math.hypot(*circle.middle) < RIG.actuator.length
    path = np.array([closed_loop.place_on(circle, t) for t in np.arange(0.0, 5.0, 0.05)])
    assert path[0] == pytest.approx(circle.middle)
    assert np.linalg.norm(path - circle.middle, axis=1).max() == pytest.approx(circle.radius)
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() / 0.05 < closed_loop.SPEED_MAX
    less = closed_loop.reduced(Settings(), (5, 10))
    assert (less["sensed"], less["law"], less["speed_max"]) == (0b1000010000, Law.FF_PI, 0.05)
    assert less["K_P"] == tuple(gain / 2 for gain in Settings().K_P)


def telemetry(n: int) -> np.ndarray:
    rows = np.zeros(n, record_dtype(Telemetry))
    rows["t_ns"] = np.arange(n) * 1_000_000
    return rows


def test_a_closed_loop_that_saturates_or_is_far_off_is_no_pass() -> None:
    rows, circle = telemetry(100), Circle((0.1, 0.1), 0.015)
    rows["error"] = (3e-3, 4e-3)
    assert closed_loop.judged(rows, 0.04, circle).good
    rows["saturated"][:10] = 1
    assert "saturated is 0.1 1, at most 0.05 1" in closed_loop.judged(rows, 0.04, circle).text
    rows["error"] = (12e-3, 0.0)
    assert "tip RMSE is 0.012 m, at most 0.01 m" in closed_loop.judged(rows, 0.04, circle).text


def test_a_decay_begins_when_the_chambers_are_empty_and_takes_each_sample_once() -> None:
    rows = telemetry(3000)
    rows["pressure_meas"][:, 0] = 100e3 * np.exp(-np.arange(3000) / 50.0)
    held = np.arange(3000) // 8  # a camera of 125 Hz
    rows["markers"][:, 9, 0] = 0.25 + 1e-4 * np.cos(held)
    rows["markers"][:, 9, 1] = 1e-4 * np.sin(held)
    rows["markers"][2000:2100, 9] = np.nan
    found = sweep.free_part(rows, 100e3, (10,))
    assert found.shape[1] == 3 and np.isfinite(found).all() and np.all(np.diff(found[:, 0]) > 0.008)
    assert 160 < len(found) < 190 and (np.diff(found[:, 1:], axis=0) != 0.0).any(axis=1).all()
    rows["pressure_meas"][:, 1] = 20e3
    with pytest.raises(CommandRefused, match="the chambers did not come below 5000 Pa"):
        sweep.free_part(rows, 100e3, (10,))


def decay(swing: float, samples: int = 200) -> np.ndarray:
    t = 0.01 * np.arange(samples)
    return np.column_stack((t, np.full(samples, 0.25), swing * np.exp(-4.0 * t) * np.cos(20.0 * t)))


def first_mode(zeta: float) -> MeasuredMode:
    """Of 3.5 Hz, as four releases have told it."""
    return MeasuredMode(
        frequency=Interval(value=3.5, low=3.4, high=3.6),
        zeta=Interval(value=zeta, low=zeta - 0.01, high=zeta + 0.01),
        kappa=Interval(value=1.0, low=1.0, high=1.0),
        friction=1e-3,
        delay=0.01,
        misfit=0.03,
        pressures=True,
        travel=0.05,
        repeats=4,
    )


def test_decays_hand_their_mode_on_to_identify_and_without_one_say_why() -> None:
    swing = first_mode(zeta=0.11)
    found = sweep.judged_decays([decay(0.05), decay(-0.05)], swing)
    assert found.good and found.text.endswith("3.50 Hz, damping ratio 0.110 (0.100 to 0.120)")
    numbers = {one.name: one for one in found.numbers}
    assert (numbers["damping ratio"].low, numbers["damping ratio"].high) == (0.1, 0.12)
    mode = identify.mode_in(result(found.text, data=found.data))
    assert mode is not None and (mode.frequency.value, mode.zeta.high) == (3.5, 0.12)
    silent = sweep.judged_decays([decay(0.05)], "the tip does not swing")
    assert silent.good and silent.text.endswith("which tell no damping: the tip does not swing")
    assert identify.mode_in(result(silent.text, data=silent.data)) is None and identify.mode_in(None) is None
    assert not sweep.judged_decays([decay(0.05, 100)], swing).good
    with_mode = identify.with_mode(found, mode, 40.0)
    kappa = {one.name: one for one in with_mode.numbers}["kappa"]
    kept = identify.mode_in(result(with_mode.text, data=with_mode.data))
    assert kept is not None and kept.kappa.value == 40.0 and kept.zeta == mode.zeta
    swings = {"controller.observer_kappa": 40.0, "twin.kappa": 40.0, "twin.zeta": 0.11}
    assert with_mode.changes == found.changes | swings
    assert identify.with_mode(found, mode, 0.3).changes["controller.observer_kappa"] == 1.0, "as a rig file may have it"
    poor = found._replace(good=False)
    assert identify.with_mode(poor, mode, 40.0).changes == poor.changes
    assert (kappa.low, kappa.high) == (pytest.approx(40.0 * (3.4 / 3.5) ** 2), pytest.approx(40.0 * (3.6 / 3.5) ** 2))


def test_a_damping_ratio_that_may_be_anything_is_none() -> None:
    identify._require_told("zeta                  0.14  0.10 .. 0.18      1        \n")
    with pytest.raises(CommandRefused, match=r"decays.csv: the damping ratio may be anything from -0.56 to 0.69"):
        identify._require_told("zeta                  0.14  -0.56 .. 0.69      1        \n")


def test_what_identify_left_over_is_read_from_its_table() -> None:
    said = "k   0.45   0.449 .. 0.451  N m/rad\nresidual, all markers      0.159  rms of 64   mm     \n"
    assert [(one.name, one.value, one.unit) for one in identify.residuals_in(said)] == [
        ("residual, all markers", 0.159, "mm")
    ]
    before = PRESETS["P1"]
    other = before.model_copy(update={"k": tuple(100.0 * k for k in before.k)})
    assert not identify.judged(other, before, "a.toml", "", said).good
    found = identify.judged(before, before, "a.toml", "text", said, "0 peaks")
    assert found.good and found.changes == {"actuator": "a.toml"} and "damping stays" in found.text


def test_going_back_forgets_what_rests_on_a_step_and_nothing_else() -> None:
    assert resting_on("drivers") == set(STEPS)
    assert resting_on("frame") == {"frame", "signs", "statics", "decay", "identify", "closed_loop"}
    assert resting_on("pressure") == {"pressure", "statics", "decay", "identify", "closed_loop"}
    assert resting_on("closed_loop") == {"closed_loop"}
    for step in STEPS:  # each rests on earlier ones
        assert all(STEPS.index(one) < STEPS.index(step) for one in RESTS_ON[step])


def rig_file(**changes: object) -> RigFile:
    return RigFile(motion_capture=MotionCapture(driver="natnet"), valves=Valves(driver="serial"), **changes)  # type: ignore[arg-type]


def test_a_fresh_rig_lacks_every_step_and_another_one_what_was_withdrawn() -> None:
    def state(rig: RigFile, **withdrawn: str) -> RigFileState:
        return RigFileState(path="", text="", rig=rig, reason="", in_force=True, withdrawn=withdrawn)  # type: ignore[arg-type]

    said = rig_file(commissioned=dict.fromkeys(STEPS, "done"))
    assert lacking(state(rig_file())) == [ABOUT[step].lacks for step in STEPS]
    assert lacking(state(said)) == []
    assert lacking(state(said, frame="it changed", signs="it rests on frame")) == [
        "frame assumed, not measured",
        "signs of both pairs not checked",
    ]
    assert value_of(said, "motion_capture.frame.measured") is False
    with pytest.raises(ParameterError, match=r"a rig file has no valves\.colour"):
        value_of(said, "valves.colour")


def result(text: str, **more: object) -> KeptResult:
    plain = {"good": True, "text": text, "by": "<b>ann</b>", "at": datetime(2026, 11, 26, tzinfo=UTC)}
    return KeptResult.model_validate(plain | more)


def test_results_outlive_a_restart_and_a_damaged_file_counts_as_nothing(tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    CommissioningStore(path).keep("frame", result("there"))
    assert CommissioningStore(path).kept.results["frame"].text == "there"
    CommissioningStore(path).forget({"frame"})
    assert CommissioningStore(path).kept.results == {}
    path.write_text('{"results": {"sky": 1}}')
    assert CommissioningStore(path).kept.results == {}


def test_the_report_escapes_everything_and_needs_nothing_outside_it() -> None:
    evil = "<script>alert(1)</script>"
    curves = [[[0.0, 0.0, 1.0, 2.0], [1.0, 5.0, None, 3.0], [2.0, 5.0, 4.0, 4.0]]] * 4
    pair = {"what": evil, "before": [0.25, None], "after": [0.24, 0.0125], "unit": "m"}
    kept = Kept(
        results={
            "pressure": result(evil, data={"curves": curves}, changes={"valves.measured": evil}),
            "statics": result("poses", data={"tips": [[0.1, 0.2], [0.2, 0.1]]}),
            "identify": result("k", data={"said": evil}),
            "signs": result("moved", data={"pairs": [pair]}),
            "closed_loop": result("round", data={"reference": [[0, 0], [1, 1]], "tip": [[0, 0], [1, 2]]}),
        }
    )
    file = RigFileState(path=evil, text=evil, rig=rig_file(), reason="", in_force=True)
    page = report.page(file, kept, None)
    assert "<script" not in page and "<b>ann" not in page and "&lt;script&gt;" in page
    assert page.count("<svg") == 6 and "http" not in page and "src=" not in page
    assert "frame assumed, not measured" in page
    assert "<td>[0.25, nan]</td><td>[0.24, 0.0125]</td><td>[-0.01, nan]</td><td>m</td>" in page
    assert report.page(RigFileState(path="", text="", rig=None, reason="gone", in_force=False), Kept(results={}), None)
