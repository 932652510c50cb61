"""Faults that are injected into the twin: what each breaks, and what the rig does about it."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from controller.arrays import Rows
from controller.assembly.plant import build_hardware
from controller.assembly.twin import build_twin
from controller.drivers.twin import inject
from controller.errors import CommandRefused
from controller.kernels.plant.faults import MARKER_LOSS, NOISE, SAMPLE_LOSS
from controller.kernels.plant.twin import Twin
from controller.realtime.command_handler import CommandHandler
from controller.schema.fit import TWIN
from controller.schema.hardware import Valves
from controller.schema.messages import TwinFaults, TwinTime
from controller.schema.modes import Cause, Freeze, Mode, Request
from controller.schema.parameters import RigParameters, TwinParameters
from tests.controller.kernels.plant.test_twin import run
from tests.controller.trial import Trial, controller_with, line

pytestmark = pytest.mark.keyed()

ROD_6 = 5


def sensed(twin: Twin, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Times of capture (k,) [ns] and markers (k,10,2) [m] of the samples delivered in that many ticks at rest."""
    measurement = run(twin, np.zeros((ticks, 4)))[1]
    fresh = np.flatnonzero(np.diff(measurement["t_ns"], prepend=0))
    return measurement["t_ns"][fresh], measurement["markers"][fresh]


def twin(**values: float) -> Twin:
    built = build_twin(RigParameters(twin=TwinParameters(seed=3)))
    built.faults.rods[0] = TwinFaults().rods
    for name, value in values.items():
        built.faults.values[{"noise": NOISE, "sample_loss": SAMPLE_LOSS, "marker_loss": MARKER_LOSS}[name]] = value
    return built


def test_without_faults_and_of_what_they_leave_alone_every_bit_stays() -> None:
    plain, lossy = sensed(twin(), 2000), sensed(twin(marker_loss=0.3), 2000)
    seen = np.isfinite(lossy[1])
    assert np.array_equal(plain[1][seen], lossy[1][seen])
    assert abs(1.0 - seen.mean() - 0.3) < 4 * math.sqrt(0.3 * 0.7 / (seen.size / 2))
    only = twin(noise=1e-3)
    only.faults.rods[0] = 1 << ROD_6
    others = np.arange(10) != ROD_6
    noisy = sensed(only, 2000)[1]
    assert np.array_equal(plain[1][:, others], noisy[:, others])
    assert abs(np.std(noisy[:, ROD_6] - plain[1][:, ROD_6]) / 1e-3 - 1.0) < 0.15


def test_a_lost_sample_is_never_delivered_and_the_next_comes_in_its_time() -> None:
    plain, lossy = sensed(twin(), 4000), sensed(twin(sample_loss=0.5), 4000)
    assert set(lossy[0]) < set(plain[0])
    assert abs(len(lossy[0]) / len(plain[0]) - 0.5) < 4 * math.sqrt(0.25 / len(plain[0]))
    kept = np.isin(plain[0], lossy[0])
    assert np.array_equal(plain[1][kept], lossy[1])
    assert len(sensed(twin(sample_loss=1.0), 100)[0]) == 0


def test_a_rig_of_hardware_refuses_faults_and_its_time_never_stands_still() -> None:
    valves = build_hardware(Valves(driver="serial"), 1e-3)
    desk = CommandHandler(*[None] * 4, SimpleNamespace(simulated=False, plant=valves), None)  # type: ignore[arg-type]
    with pytest.raises(CommandRefused, match="this rig is hardware"):
        desk.faults(TwinFaults(noise=1e-3))
    with pytest.raises(CommandRefused, match="this rig is hardware"):
        desk.time(TwinTime(paused=True))


BENT = (0.0, 60e3, 120e3, 0.0)
"""Setpoints of an ordinary pose [Pa]."""


def broken(fault: TwinFaults, setpoints: np.ndarray) -> tuple[Twin, np.ndarray]:
    """A twin held at BENT for a second, and its sensors (n,4) [Pa] while `fault` meets it at `setpoints` (n,4) [Pa]."""
    built = build_twin(RigParameters(twin=TwinParameters(seed=3)))
    run(built, np.tile(BENT, (1000, 1)))
    inject(fault, built.faults)
    return built, run(built, setpoints)[1]["pressures"]


HELD, RAISED = np.tile(BENT, (1000, 1)), np.tile((0.0, 60e3, 160e3, 0.0), (1000, 1))


def test_all_faults_off_keep_every_bit() -> None:
    whole = twin_with_faults_off()
    assert np.array_equal(sensed(twin(), 500)[1], sensed(whole, 500)[1])
    assert np.array_equal(broken(TwinFaults(), RAISED)[1], broken(TwinFaults(noise=1e-3), RAISED)[1])


def twin_with_faults_off() -> Twin:
    built = build_twin(RigParameters(twin=TwinParameters(seed=3)))
    inject(TwinFaults(noise=1e-3, jump=(0.1, 0.1), freeze=Freeze.FRESH_TIME, supply_lost=True), built.faults)
    inject(TwinFaults(), built.faults)
    return built


def test_a_jump_moves_its_markers_by_just_that() -> None:
    moved = twin()
    inject(TwinFaults(jump=(0.0, 0.05), rods=1 << ROD_6), moved.faults)
    apart = sensed(moved, 500)[1] - sensed(twin(), 500)[1]
    assert apart[:, ROD_6] == pytest.approx(np.broadcast_to([0.0, 0.05], apart[:, ROD_6].shape))
    assert not np.delete(apart, ROD_6, axis=1).any()


@pytest.mark.parametrize("latency", [0.004, 0.03])
def test_a_frozen_camera_repeats_its_sample_under_fresh_times_or_not_at_all(latency: float) -> None:
    built = build_twin(RigParameters(twin=TwinParameters(seed=3, marker_latency=latency)))
    before = sensed(built, 100)[1]
    for freeze, delivered in ((Freeze.FRESH_TIME, 50), (Freeze.OLD_TIME, 0)):
        inject(TwinFaults(freeze=freeze), built.faults)
        sensed(built, 50)  # what was on its way has come
        times, points = sensed(built, 500)
        assert len(times) == delivered
        assert (np.diff(times) == 10_000_000).all()
        assert (points == points[:1]).all()
    inject(TwinFaults(), built.faults)
    sensed(built, 50)
    assert len(np.unique(sensed(built, 500)[1][:, 0, 0])) == 50
    assert len(np.unique(before[:, 0, 0])) == len(before)


def test_a_stuck_sensor_shows_its_value_whatever_its_chamber_does() -> None:
    built, shown = broken(TwinFaults(sensors_stuck=0b0100), RAISED)
    assert (shown[:, 2] == shown[0, 2]).all()
    assert built.chambers.pressure[2] > 300e3, "its loop goes on filling"
    assert np.array_equal(shown[:, [0, 1, 3]], broken(TwinFaults(), RAISED)[1][:, [0, 1, 3]])


def test_a_stuck_valve_leaves_its_chamber_alone_with_its_opening() -> None:
    shown = broken(TwinFaults(valves_stuck=0b0100), RAISED)[1]
    assert np.abs(shown[:, 2] - BENT[2]).max() < 15e3
    assert np.array_equal(shown[:, [0, 1, 3]], broken(TwinFaults(), RAISED)[1][:, [0, 1, 3]])


def test_without_a_supply_every_chamber_empties() -> None:
    assert broken(TwinFaults(supply_lost=True), RAISED)[1][-1].max() < 1e3
    assert broken(TwinFaults(), HELD)[1][-1, 2] == pytest.approx(BENT[2], rel=0.02)


def test_an_e_stop_empties_chambers_whose_sensors_and_valves_are_stuck() -> None:
    trial = Trial()
    trial.arm()
    trial.follow(0.12, 0.1, 1.5)
    inject(TwinFaults(sensors_stuck=15, valves_stuck=15), trial.twin.faults)
    assert trial.twin.chambers.pressure.max() > 50e3
    trial.ask(Request.E_STOP, ticks=1000)
    assert trial.twin.chambers.pressure.max() < 1e3


REACTIONS = [
    (TwinFaults(freeze=Freeze.FRESH_TIME), Mode.FAULT, Cause.MEASUREMENT_FROZEN),
    (TwinFaults(freeze=Freeze.OLD_TIME), Mode.FAULT, Cause.MEASUREMENT_LOST),
    (TwinFaults(sample_loss=1.0), Mode.FAULT, Cause.MEASUREMENT_LOST),
    (TwinFaults(marker_loss=1.0), Mode.FAULT, Cause.MEASUREMENT_LOST),
    (TwinFaults(jump=(0.0, 0.05)), Mode.FAULT, Cause.MEASUREMENT_JUMPED),
    (TwinFaults(jump=(-0.05, 0.0)), Mode.FAULT, Cause.MEASUREMENT_JUMPED),
    (TwinFaults(sensors_stuck=15), Mode.E_STOP, Cause.PRESSURE_MISMATCH),
    (TwinFaults(valves_stuck=15), Mode.E_STOP, Cause.PRESSURE_MISMATCH),
    (TwinFaults(supply_lost=True), Mode.E_STOP, Cause.PRESSURE_MISMATCH),
]


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
@pytest.mark.parametrize(("fault", "mode", "cause"), REACTIONS)
def test_the_rig_notices_what_breaks_while_it_follows_and_works_again(
    name: str, fault: TwinFaults, mode: Mode, cause: Cause
) -> None:
    trial = Trial(name)
    trial.arm()
    trial.follow(0.12, 0.1, 1.5)
    inject(fault, trial.twin.faults)
    rows = trial.drag(line((0.12, 0.1), (0.12, -0.1), 40), 4.0)
    first = np.flatnonzero(rows["mode"] != Mode.FOLLOW)
    assert first.size and (rows["mode"][first[0]], rows["cause"][first[0]]) == (mode, cause)
    inject(TwinFaults(), trial.twin.faults)
    trial.run(3000)
    trial.ask(Request.CLEAR, ticks=20)
    trial.ask(Request.ARM, ticks=20)
    row = trial.follow(0.15, 0.05, 3.0)[-1]
    assert row["mode"] == Mode.FOLLOW
    assert np.hypot(*row["error"]) < 1e-2


@pytest.mark.parametrize("kappa", [1.0, TWIN["kappa"], 100.0])
@pytest.mark.parametrize("sensed", [1 << 9, 1 << 9 | 1 << 5, 1023])
def test_a_jump_is_no_model_that_moves_too_fast_whatever_its_inertia(sensed: int, kappa: float) -> None:
    """A body of a fortieth of the inertia leaps six times as fast, which was an E-STOP, though nothing diverged."""
    for jump, mode, cause in [
        ((0.0, 0.03), Mode.HOLD, Cause.OPERATOR),
        ((0.0, 0.05), Mode.FAULT, Cause.MEASUREMENT_JUMPED),
    ]:
        trial = Trial(parameters=controller_with(observer_kappa=kappa), sensed=sensed)
        trial.arm()
        trial.run(500)
        inject(TwinFaults(jump=jump), trial.twin.faults)
        row = trial.run(1000)[-1]
        assert (row["mode"], row["cause"]) == (mode, cause)


def track(trial: Trial, path: np.ndarray, ticks: int) -> Rows:
    """Arm, go to where the closed `path` (n,2) [m] begins, hold, and follow it, a point a tick, for that many ticks."""
    trial.arm()
    trial.follow(*path[0], 2.0)
    trial.ask(Request.HOLD, ticks=300)
    trial.rig.control.reference[: len(path)], trial.rig.control.guide[: len(path)] = path, np.nan
    trial.rig.control.plan[0] = len(path), 0, 100_000
    return trial.ask(Request.TRACK, ticks=ticks)


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.5, 0.8])
@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_one_stuck_sensor_is_named_before_the_swing_that_comes_of_it(name: str, phase: float) -> None:
    """The feedback swings the arm at once, while the mismatch comes and goes; what tells is a reading that is still."""
    trial, angle = Trial(name), np.linspace(0.0, 2 * np.pi, 1000, endpoint=False)
    track(trial, np.column_stack([0.12 + 0.05 * np.sin(angle), 0.08 * np.cos(angle)]), 1000 + round(1000 * phase))
    inject(TwinFaults(sensors_stuck=1 << 1), trial.twin.faults)
    row = trial.run(3000)[-1]
    assert (row["mode"], row["cause"]) == (Mode.E_STOP, Cause.PRESSURE_MISMATCH)


def test_a_short_dropout_and_a_spike_are_ridden_out() -> None:
    trial = Trial()
    trial.arm()
    trial.follow(0.12, 0.1, 1.5)
    for fault in (TwinFaults(sample_loss=1.0), TwinFaults(jump=(0.0, 0.05)), TwinFaults(marker_loss=1.0)):
        inject(fault, trial.twin.faults)
        trial.run(200)
        inject(TwinFaults(), trial.twin.faults)
        rows = trial.run(1000)
        assert (rows["mode"] == Mode.FOLLOW).all()
        assert np.hypot(*rows["error"][-1]) < 1e-2


@pytest.mark.parametrize("phase", [0.0, 0.5, 1.0, 1.5])
def test_a_jump_is_noticed_in_fast_motion_too(phase: float) -> None:
    """On a circle of 1 Hz, whose tip makes 0.5 m/s and whose model drifts without markers."""
    trial, angle = Trial(), np.linspace(0.0, 2 * np.pi, 1000, endpoint=False)
    rows = track(trial, np.column_stack([0.14 + 0.05 * np.cos(angle), 0.08 * np.sin(angle)]), 2000 + round(500 * phase))
    assert (rows["mode"] == Mode.TRACK).all()
    assert rows["sensed"][500:].all(), "none is taken for a jump"
    inject(TwinFaults(jump=(0.05 * np.cos(phase * np.pi), 0.05 * np.sin(phase * np.pi))), trial.twin.faults)
    row = trial.run(800)[-1]
    assert (row["mode"], row["cause"]) == (Mode.FAULT, Cause.MEASUREMENT_JUMPED)


@pytest.mark.parametrize("jump", [(0.0, 0.05), (0.04, 0.03)])
@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
def test_a_jump_is_noticed_though_markers_are_often_not_seen(name: str, jump: tuple[float, float]) -> None:
    trial = Trial(name)
    inject(TwinFaults(marker_loss=0.3), trial.twin.faults)
    trial.arm()
    assert trial.follow(0.12, 0.1, 1.5)["mode"][-1] == Mode.FOLLOW
    inject(TwinFaults(marker_loss=0.3, jump=jump), trial.twin.faults)
    row = trial.run(800)[-1]
    assert (row["mode"], row["cause"]) == (Mode.FAULT, Cause.MEASUREMENT_JUMPED)


def test_a_marker_that_jumped_is_not_used_but_the_others_are() -> None:
    trial = Trial(sensed=1 << 5 | 1 << 9)
    trial.arm()
    trial.follow(0.12, 0.1, 1.5)
    inject(TwinFaults(jump=(0.0, 0.05), rods=1 << 9), trial.twin.faults)
    rows = trial.run(2000)
    assert (rows["mode"] == Mode.FOLLOW).all()
    assert (rows["sensed"][100:] == 1 << 5).all()
    assert np.isnan(rows["p_meas"][100:]).all()
