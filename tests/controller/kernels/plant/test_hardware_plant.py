"""The last stage before real valves: nothing leaves that is beyond its limits, whatever the loop asks."""

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.assembly.plant import build_hardware, build_plant
from controller.assembly.rig import build_rig
from controller.errors import ParameterError
from controller.kernels.plant.hardware import Hardware, hardware_step
from controller.kernels.plant.twin import twin_step
from controller.realtime.loop import loop_memory, run_loop
from controller.realtime.mailbox import receive, words
from controller.realtime.ring import HEADER_WORDS, ROW_WORDS, STOP
from controller.schema.actuator import PRESETS
from controller.schema.hardware import PressureLoop, Valves
from controller.schema.layout import record_dtype
from controller.schema.messages import Measurement, Telemetry, ValveCommand
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters
from controller.schema.rig_file import parse_rig_file
from controller.virtual.plant import BEHIND_MAX_NS, RunningPlant, next_slot

DT = 1e-3
DRIVEN = (Mode.HOLD, Mode.FOLLOW, Mode.TRACK, Mode.REST, Mode.FAULT)
Number = st.floats(allow_nan=True, allow_infinity=True, width=64)


def hardware(**fields: Any) -> Hardware:
    return build_hardware(Valves(driver="serial", **fields), DT)


class Stage:
    """One stage, and what it is asked."""

    def __init__(self, **fields: Any) -> None:
        self.hardware = hardware(**fields)
        self.row, self.sensed = (np.zeros(1, record_dtype(model)) for model in (Telemetry, Measurement))

    def step(self, mode: Mode, asked: Any, shown: Any = (0.0, 0.0, 0.0, 0.0)) -> np.void:
        self.row["mode"], self.row["pressure_cmd"], self.row["pressure_meas"] = mode, asked, shown
        hardware_step(1, self.hardware, self.row[0], self.sensed[0])
        command: np.void = self.hardware.command[0]
        return command


@settings(deadline=None)
@given(st.lists(st.tuples(st.sampled_from(list(Mode)), st.tuples(*[Number] * 4)), min_size=1, max_size=30))
def test_whatever_is_asked_setpoints_stay_within_range_and_rate(asked: list[tuple[Mode, tuple[float, ...]]]) -> None:
    stage, last = Stage(pressure_max=200e3, slew_max=10e6), np.zeros(4)
    for mode, pressures in asked:
        command = stage.step(mode, pressures)
        now = command["pressures"].copy()
        assert np.isfinite(now).all() and (now >= 0.0).all() and (now <= 200e3).all()
        if command["vent"]:
            assert not now.any() and (command["openings"] == -1.0).all()
        else:
            assert np.abs(now - last).max() <= 10e6 * DT * (1 + 1e-9)
            assert mode in DRIVEN and np.isfinite(pressures).all()
        assert bool(command["cut"]) == (mode == Mode.E_STOP)
        last = now


RIG = """
[motion_capture]
driver = "json"
[valves]
driver = "serial"
pressure_max = {}
"""


@settings(deadline=None, max_examples=20)
@given(st.sampled_from(sorted(PRESETS)), st.floats(2e3, 1e6))
def test_no_torque_is_asked_for_whose_pressure_the_valves_may_not_have(name: str, pressure_max: float) -> None:
    rig = parse_rig_file(RIG.format(pressure_max), "rig.toml").model_copy(update={"actuator": name})
    found, named = rig.parameters(Path()), PRESETS[name]
    u_max = found.actuator.u_max
    assert u_max * max(named.pressure_map) <= pressure_max * (1 + 1e-12) and u_max <= named.u_max
    assert found.actuator == named.model_copy(update={"u_max": u_max})
    assert u_max == named.u_max or u_max * max(named.pressure_map) >= pressure_max * (1 - 1e-12)
    assert found.with_actuator(named) == found
    assert RigParameters().with_actuator(named).actuator is named, "a twin has no valves"


def test_valves_that_may_do_next_to_nothing_are_refused_with_both_numbers() -> None:
    with pytest.raises(ParameterError, match=r"valves.pressure_max = 100 Pa makes u_max = 2.49e-05 N m of actuator P1"):
        parse_rig_file(RIG.format(100.0), "rig.toml").parameters(Path())


@pytest.mark.parametrize("mode", DRIVEN)
def test_setpoints_reach_what_is_asked_in_every_driven_state(mode: Mode) -> None:
    stage = Stage()
    for _ in range(20):
        command = stage.step(mode, (1e5, 0.0, 0.0, 2e5))
    assert tuple(command["pressures"]) == (1e5, 0.0, 0.0, 2e5)


@pytest.mark.parametrize("mode", [Mode.VENTED, Mode.E_STOP])
def test_a_stopped_rig_vents_at_once_and_starts_again_from_nothing(mode: Mode) -> None:
    stage = Stage(slew_max=1e6)
    for _ in range(300):
        stage.step(Mode.HOLD, (1e5, 1e5, 1e5, 1e5))
    command = stage.step(mode, (1e5, 1e5, 1e5, 1e5))
    assert command["vent"] and not command["pressures"].any()
    assert stage.step(Mode.HOLD, (1e5, 1e5, 1e5, 1e5))["pressures"].max() <= 1e6 * DT


def test_a_pressure_that_is_not_a_number_vents_everything() -> None:
    stage = Stage()
    assert not stage.step(Mode.HOLD, (1e5, 0.0, 0.0, 0.0))["vent"]
    assert stage.step(Mode.HOLD, (1e5, math.nan, 0.0, 0.0))["vent"]


def test_openings_of_raw_valves_have_the_sign_of_the_error_and_stay_within_the_stroke() -> None:
    stage = Stage(command="opening")
    for _ in range(100):
        command = stage.step(Mode.HOLD, (1e5, 0.0, 5e4, 0.0), shown=(0.0, 5e4, 5e4, 0.0))
    openings = command["openings"]
    assert openings[0] > 0.0 > openings[1]
    assert abs(openings[2]) < 1e-9
    assert np.abs(openings).max() <= 1.0


def test_the_loop_of_raw_valves_holds_pressures_of_the_twins_chambers() -> None:
    loop = PressureLoop(inflate_gain=2e-6, exhaust_gain=4e-6, integral_time=0.5)
    stage = Stage(command="opening", loop=loop)
    parameters = RigParameters()
    quick = parameters.twin.model_copy(update={"dead_time": 0.005})
    plant = build_plant(parameters.model_copy(update={"twin": quick}))
    plant.chambers.raw[0] = 1
    row, sensed = (np.zeros(1, record_dtype(model)) for model in (Telemetry, Measurement))
    asked = (8e4, 0.0, 0.0, 4e4)
    for _ in range(3000):
        command = stage.step(Mode.HOLD, asked, shown=sensed["pressures"][0])
        row["mode"], row["pressure_cmd"] = Mode.HOLD, command["openings"]
        twin_step(1, plant, row[0], sensed[0])
    assert np.abs(sensed["pressures"][0] - asked).max() < 2e3


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.FAULT, Mode.E_STOP])
def test_the_last_thing_that_the_valves_are_told_is_to_vent_and_in_e_stop_the_cut_stays(mode: Mode) -> None:
    header, rows = np.zeros(HEADER_WORDS, np.int64), np.zeros((4, ROW_WORDS), np.int64)
    header[STOP] = 1
    stage = hardware()
    stage.command["vent"], stage.command["pressures"] = 0, 5e4
    memory = loop_memory(header, rows, rig := build_rig(RigParameters(), boot=1), stage)
    memory.telemetry["mode"] = mode
    run_loop(rig, stage, memory, 1_000_000)
    told = np.zeros(1, record_dtype(ValveCommand))
    receive(memory.outlets, 0, words(told).copy(), words(told))
    assert told["vent"][0] == 1 and not told["pressures"].any() and told["t_ns"][0] > 0
    assert bool(told["cut"][0]) == (mode == Mode.E_STOP)


@pytest.mark.parametrize("raw", [False, True])
def test_a_running_plant_fills_and_empties_as_it_is_told(raw: bool) -> None:
    plant = RunningPlant(RigParameters(), raw)
    plant.start()
    try:
        plant.drive(np.array([6e4, 0.0, 0.0, 0.0]), np.array([0.05, -1.0, -1.0, -1.0]), vent=False, cut=False)
        peak = _until(lambda: plant.newest()["pressures"][0] > 3e4)
        plant.drive(np.full(4, 6e4), np.ones(4), vent=True, cut=False)
        empty = _until(lambda: plant.newest()["pressures"][0] < 5e3)
    finally:
        plant.stop()
    assert peak and empty


def test_a_running_plant_that_is_behind_leaves_no_slot_out_unless_its_machine_slept() -> None:
    """Its time is the rig's: chambers of a plant that left slots out on a busy machine would seem slower by a tenth."""
    period, second = 1_000_000, 1_000_000_000
    for behind in (-period, 0, period, 200 * period, second):
        assert next_slot(second, second + behind, period) == second + period
    assert next_slot(second, 9 * second, period) == 8 * second + period


def test_a_running_plant_has_the_times_of_its_slots() -> None:
    plant, period_ns = RunningPlant(RigParameters(), False), 1000  # faster than it can
    plant._period_ns = period_ns
    plant.start()
    try:
        steps, begun = _time_of(plant)
        time.sleep(0.2)
        done, ended = _time_of(plant)
        slept = time.monotonic_ns() - ended >= BEHIND_MAX_NS
    finally:
        plant.stop()
    assert slept or (ended - begun) // period_ns < done - steps + 1000, "a reading may be some steps old"


def _time_of(plant: RunningPlant) -> tuple[int, int]:
    """Steps so far, and the time of a late one [ns]."""
    return int(plant.plant.ticks[0]), int(plant.newest()["t_ns"])


def _until(what: Any) -> bool:
    end = time.monotonic() + 20.0
    while not what():
        if time.monotonic() > end:
            return False
        time.sleep(1e-3)
    return True
