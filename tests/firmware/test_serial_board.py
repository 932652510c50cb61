"""The driver and the firmware over a real pseudo-terminal."""

import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from controller.drivers.device import DeviceError
from controller.drivers.valves.serial_board.driver import SerialBoard, SerialOptions
from controller.errors import ParameterError
from controller.schema.hardware import Valves
from controller.schema.rig_file import parse_rig_file
from controller.virtual.rig import VirtualRig
from server.campaign.rows.wires import MODBUS, SERIAL
from tests.controller.drivers.effort import Waits
from tests.firmware.conftest import VENT, Bench, answer, outlet, stays, wait_for

pytestmark = pytest.mark.alone


def test_the_board_says_what_it_is(bench: Bench) -> None:
    board = bench.device().board
    assert board is not None
    assert (board.name, board.channels, board.firmware, board.watchdog_ms) == ("host", 8, 0x0100, 100)
    assert (board.pressure_max, board.pressure_trip, board.slew_max) == (300_000, 340_000, 20_000_000)


def test_a_board_obeys_only_after_it_was_vented(bench: Bench) -> None:
    device = bench.device()
    said = stays(device, outlet(50e3), 0.05)
    assert {one.stopped for one in said} == {"it started again"}
    assert wait_for(lambda: bench.vented)
    assert answer(device, VENT).stopped == ""
    stays(device, outlet(50e3), 0.03)
    assert wait_for(lambda: bench.drive is not None and bench.drive.pressures[0] == 50e3)


def test_chambers_hang_at_the_channels_that_the_rig_file_says(bench: Bench) -> None:
    device = bench.driven((6, 2, 0, 5))
    bench.pressures = np.arange(16) * 1e3
    said = stays(device, outlet(10e3, 20e3, 30e3, 40e3), 0.05)[-1]
    assert said.pressures.tolist() == [6e3, 2e3, 0.0, 5e3]
    assert wait_for(lambda: bench.drive is not None and bench.drive.pressures[5] == 40e3)
    assert bench.drive is not None
    assert bench.drive.pressures[:8].tolist() == [30e3, 0, 20e3, 0, 0, 40e3, 10e3, 0]
    assert bench.drive.openings[[1, 3, 4, 7]].tolist() == [-1.0] * 4


def test_openings_go_through_unchanged(bench: Bench) -> None:
    device = bench.driven(raw=True)
    stays(device, outlet(openings=(1.0, -0.5, 0.25, 0.0)), 0.05)
    assert wait_for(lambda: bench.drive is not None and bench.drive.raw and not bench.drive.vent)
    assert bench.drive is not None
    assert bench.drive.openings[:4] == pytest.approx([1.0, -0.5, 0.25, 0.0], abs=1 / 32767)


def test_no_valve_fills_a_chamber_at_the_limit(bench: Bench) -> None:
    device = bench.driven(raw=True)
    bench.pressures = np.full(16, 310e3)
    stays(device, outlet(openings=(1.0, 1.0, -1.0, 0.5)), 0.05)
    assert wait_for(lambda: bench.drive is not None and bench.drive.openings[:4].tolist() == [0.0, 0.0, -1.0, 0.0])


def test_no_setpoint_above_the_boards_limit_is_followed(bench: Bench) -> None:
    device = bench.driven()
    stays(device, outlet(900e3, 1e9), 0.1)
    assert wait_for(lambda: bench.drive is not None and bench.drive.pressures[:2].tolist() == [300e3, 300e3])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_vents(bench: Bench, value: float) -> None:
    device = bench.driven()
    stays(device, outlet(50e3), 0.03)
    stays(device, outlet(50e3, value), 0.03)
    assert wait_for(lambda: bench.vented)


def test_a_cut_vents_and_cuts_the_supply(bench: Bench) -> None:
    device = bench.driven()
    stays(device, outlet(50e3), 0.03)
    answer(device, outlet(vent=True, cut=True))
    assert wait_for(lambda: bench.drive is not None and bench.drive.vent and bench.drive.cut)
    stays(device, VENT, 0.02)
    assert wait_for(lambda: bench.drive is not None and bench.drive.vent and not bench.drive.cut)


def test_too_much_pressure_vents_and_cuts_until_it_is_gone_and_the_host_has_vented(bench: Bench) -> None:
    device = bench.driven()
    stays(device, outlet(50e3), 0.03)
    bench.pressures = np.array([345e3, *[0.0] * 15])
    assert stays(device, outlet(50e3), 0.05)[-1].stopped == "a pressure was above its 340000 Pa"
    assert wait_for(lambda: bench.drive is not None and bench.drive.vent and bench.drive.cut)
    assert stays(device, VENT, 0.02)[-1].stopped != ""
    bench.pressures = np.zeros(16)
    assert stays(device, outlet(50e3), 0.03)[-1].stopped != ""
    assert stays(device, VENT, 0.02)[-1].stopped == ""


def test_the_hardware_stop_latches(bench: Bench) -> None:
    device = bench.driven()
    bench.peer.press_e_stop(True)
    assert stays(device, outlet(50e3), 0.03)[-1].stopped == "its hardware stop was pressed"
    assert stays(device, VENT, 0.02)[-1].stopped != ""
    bench.peer.press_e_stop(False)
    assert stays(device, outlet(50e3), 0.02)[-1].stopped != ""
    assert wait_for(lambda: bench.vented)
    assert stays(device, VENT, 0.02)[-1].stopped == ""


def test_a_broken_sensor_is_no_number_and_stops_what_hangs_at_it(bench: Bench) -> None:
    device = bench.driven((0, 1, 2, 3))
    bench.pressures = np.array([0.0] * 7 + [np.nan] + [0.0] * 8)
    assert stays(device, outlet(50e3), 0.03)[-1].stopped == ""
    bench.pressures = np.array([0.0, np.nan, *[0.0] * 14])
    said = stays(device, outlet(50e3), 0.05)[-1]
    assert np.isnan(said.pressures).tolist() == [False, True, False, False]
    assert said.stopped == "a pressure sensor in use is broken"


def test_a_reset_is_seen_and_the_board_waits_for_a_vent(bench: Bench) -> None:
    device = bench.driven()
    stays(device, outlet(50e3), 0.03)
    bench.peer.reset()
    assert wait_for(lambda: answer(device, outlet(50e3)).stopped == "it started again")
    assert wait_for(lambda: bench.vented)
    assert stays(device, outlet(50e3), 0.05)[-1].stopped == "it started again"
    assert device.board is not None
    assert device.board.boot == 2
    answer(device, VENT)
    assert stays(device, outlet(50e3), 0.03)[-1].stopped == ""
    assert wait_for(lambda: not bench.vented)


def test_a_board_that_hangs_says_nothing_and_begins_again_vented(bench: Bench) -> None:
    device = bench.driven()
    stays(device, outlet(50e3), 0.03)
    bench.peer.freeze()
    assert device._line is not None
    waits = Waits(device._line._poll)
    device._line._poll = waits  # type: ignore[assignment]
    assert [device.exchange(outlet(50e3), 0.1) for _ in range(120)][-1] is None
    assert max(waits.asked) <= device.options.timeout < 0.1, "its own bound, where it is the shorter"
    assert wait_for(lambda: bench.vented)
    bench.peer.thaw()
    assert wait_for(lambda: answer(device, outlet(50e3)).stopped != "")
    assert wait_for(lambda: bench.vented)


def test_a_pulled_cable_is_a_lost_device_and_comes_back_under_the_same_name(bench: Bench) -> None:
    device = bench.driven()
    stays(device, outlet(50e3), 0.03)
    bench.peer.unplug()
    with pytest.raises((DeviceError, OSError)):
        stays(device, outlet(50e3), 1.0)
    with pytest.raises(OSError, match="No such file"):
        device.open()
    assert wait_for(lambda: bench.vented)
    bench.peer.plug()
    device.open()
    assert "watchdog vented" in answer(device, outlet(50e3)).stopped
    assert answer(device, VENT).stopped == ""


def test_a_rig_that_waits_for_pressures_stands_before_a_board_that_waits_for_commands(tmp_path: Path) -> None:
    """Where a machine paused for 0.1 s the board vented until told to, so the rig was in E-STOP a second later."""
    rig = VirtualRig(parse_rig_file(f"{SERIAL}\n[limits]\npressures_lost = 1.0", "a patient rig"), tmp_path)
    with closing(rig.valves) as peer:
        peer.plug()
        device = SerialBoard(SerialOptions(port=str(peer.options["port"])), (0, 1, 2, 3), raw=False)
        device.open()
        assert device.board is not None and device.board.watchdog_ms == 1000
        answer(device, VENT)
        answer(device, outlet(50e3))
        time.sleep(0.3)
        assert answer(device, outlet(50e3)).stopped == ""
        device.close()


def test_the_virtual_rig_holds_back_a_serial_boards_answers_until_it_is_mended(tmp_path: Path) -> None:
    rig = VirtualRig(parse_rig_file(SERIAL, "a rig"), tmp_path)
    with closing(rig.valves) as peer:
        peer.plug()
        device = SerialBoard(SerialOptions(port=str(peer.options["port"]), timeout=0.01), (0, 1, 2, 3), raw=False)
        with closing(device):
            device.open()
            rig.do("hold_back 0.06")
            assert wait_for(lambda: device.exchange(VENT, 0.1) is not None and device.late > 5)
            assert device.notice.endswith("timeout is 10 ms")
            rig.do("mend")
            assert wait_for(lambda: device.exchange(VENT, 0.1) is not None and device.notice == "", 20.0)
    other = VirtualRig(parse_rig_file(MODBUS, "a rig"), tmp_path)
    with closing(other.valves), pytest.raises(ParameterError, match="serial"):
        other.do("hold_back 0.015")


def test_a_board_without_power_lets_go_of_everything(bench: Bench) -> None:
    device = bench.driven()
    stays(device, outlet(50e3), 0.03)
    bench.peer.power_off()
    with pytest.raises((DeviceError, OSError)):
        stays(device, outlet(50e3), 1.0)
    assert wait_for(lambda: bench.drive is not None and bench.drive.vent and bench.drive.cut)
    bench.peer.plug()
    device.open()
    assert device.board is not None
    assert device.board.boot == 2


def test_half_an_answer_is_lost_and_counted(bench: Bench) -> None:
    device = bench.driven()
    numbers = [answer(device, VENT).number]
    bench.peer.half_frame()
    while device.rejected == 0 and len(numbers) < 500:
        numbers.append(answer(device, VENT).number)
    assert device.rejected == 1
    assert len(range(numbers[0], numbers[-1])) >= len(numbers)


def test_a_board_behind_a_slow_adapter_is_driven_and_its_answers_are_counted_as_late(bench: Bench) -> None:
    device = bench.driven()
    bench.peer.hold_back(0.03)
    bench.pressures = np.arange(16) * 1e3
    late = device.late
    said = [answer(device, outlet(50e3)) for _ in range(60)]
    assert said[-1].pressures.tolist() == [0.0, 1e3, 2e3, 3e3] and said[-1].stopped == ""
    assert wait_for(lambda: bench.drive is not None and bench.drive.pressures[0] == 50e3)
    assert device.late > late and "timeout is 10 ms" in device.notice
    assert device.rejected == 0


def test_the_port_is_ours_alone(bench: Bench) -> None:
    bench.device()
    with pytest.raises(OSError, match="exclusive"):
        bench.device()


def test_a_board_with_too_few_channels_is_refused(bench: Bench) -> None:
    with pytest.raises(DeviceError, match="names channel 8; the board has 0 to 7"):
        bench.device((0, 1, 2, 8))


def test_pressures_are_timed_on_our_clock_across_a_wrap_of_the_boards(bench: Bench) -> None:
    device = bench.driven()
    wrapped, clocks = False, []
    end = time.monotonic() + 8.0
    while not wrapped and time.monotonic() < end:
        before = time.monotonic_ns()
        said = answer(device, VENT)
        clocks.append(device.clock_offset)
        wrapped = int(bench.peer.words[53]) < 2**31
        assert before - 50_000_000 < said.t_ns <= time.monotonic_ns()
        time.sleep(0.01)
    assert wrapped
    assert max(clocks) - min(clocks) < 0.05


@pytest.mark.parametrize(
    ("options", "text"),
    [({"port": ""}, "port"), ({"port": "x", "baud": 300}, "baud"), ({"port": "x", "timeout": 0.25}, "timeout")],
)
def test_options_outside_their_bounds_are_refused(options: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        SerialOptions.model_validate(options)


def test_a_rig_file_names_the_driver() -> None:
    from controller.drivers.registry import valve_device

    device = valve_device(Valves(driver="serial", options={"port": "/dev/nothing"}))
    assert isinstance(device, SerialBoard)
    assert device.name == "/dev/nothing at 1000000 baud"
    with pytest.raises(OSError, match="/dev/nothing"):
        device.open()
