import re

import numpy as np
import pytest
from typer.testing import CliRunner

from controller.drivers.registry import capture_class, valve_class
from controller.errors import ParameterError
from controller.virtual.bench import Chambers
from controller.virtual.peers import Drive
from controller.virtual.udp_target import UdpTargetPeer
from server.cli.drivers import app, parsed

run = CliRunner()


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("controller.drivers.conformance.frames.SPAN", 0.2)


def test_the_list_names_every_driver_and_which_can_be_tried_without_hardware() -> None:
    done = run.invoke(app, ["list"], env={"COLUMNS": "200"})
    rows = {line.split()[0]: line for line in done.output.splitlines() if line}
    assert done.exit_code == 0
    assert {"serial", "natnet", "udp", "modbus", "nidaq"} <= set(rows)
    assert "valves" in rows["modbus"] and " yes " in rows["modbus"] and " no " in rows["nidaq"]


def test_check_prints_a_row_for_each_check_and_fails_if_one_does() -> None:
    done = run.invoke(app, ["check", "udp"], env={"COLUMNS": "200"})
    assert done.exit_code == 0
    assert re.search(r"shown +vents when told", done.output) and re.search(r"shown +survives a loss", done.output)
    done = run.invoke(app, ["check", "udp", "-o", "host=127.0.0.1", "-o", "port=1", "-o", "connect_time=0.05"])
    assert done.exit_code == 1
    assert re.search(r"failed +keeps to its time", done.output) and re.search(
        r"not shown +survives a loss", done.output
    )


def test_what_was_not_shown_is_no_success() -> None:
    chambers = Chambers()
    target = UdpTargetPeer(chambers.pressures, chambers.take)
    target.plug()
    try:
        there = [f"--options={name}={value}" for name, value in target.options.items()]
        done = run.invoke(app, ["check", "udp", *there], env={"COLUMNS": "200"})
        recorded = run.invoke(app, ["check", "udp", *there, "--decode", f"{__name__}:decode"], env={"COLUMNS": "200"})
    finally:
        target.close()
    assert done.exit_code == 3 and re.search(r"not shown +vents when told", done.output)
    assert "6 shown, 7 not shown, 0 failed" in done.output
    assert recorded.exit_code == 3 and re.search(r"shown +sends nothing impossible", recorded.output)


def decode(sent: bytes) -> Drive | None:
    """Of the udp driver's datagrams: whatever they hold, they vent."""
    return Drive(np.zeros(16), np.zeros(16), False, True, False) if sent else None


def test_what_cannot_be_checked_is_said() -> None:
    assert "there are" in str(run.invoke(app, ["check", "nothing"]).exception)
    for driver in ("nidaq", "lsl"):
        assert f"driver {driver} has no virtual peer" in run.invoke(app, ["check", driver, "--peer"]).output
    for place in ("nothing", "json:nothing", "json:__doc__"):
        done = run.invoke(app, ["check", "udp", "-o", "port=1", "--decode", place])
        assert done.exit_code == 2 and "--decode" in done.output
    assert "none of host" in str(
        run.invoke(app, ["check", "json", "-o", "sender=127.0.0.1", "-o", "port=9", "--record"]).exception
    )
    assert "this is the virtual peer" in str(run.invoke(app, ["check", "udp", "--peer", "--record"]).exception)
    assert "driver.options.port = 0" in str(run.invoke(app, ["check", "modbus", "-o", "port=0"]).exception)


def test_who_names_no_driver_is_told_those_that_fit() -> None:
    with pytest.raises(ParameterError) as cameras:
        capture_class("optitrack")
    assert "natnet" in str(cameras.value) and "modbus" not in str(cameras.value)
    with pytest.raises(ParameterError, match=r"valves\.driver = festo: there are .*modbus.*udp") as valves:
        valve_class("festo")
    assert "natnet" not in str(valves.value)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("port=5020", ("port", 5020)),
        ("host=10.0.0.1", ("host", "10.0.0.1")),
        ("combined=false", ("combined", False)),
        ("pressure_registers=[1, 2]", ("pressure_registers", [1, 2])),
        ("dump_line=", ("dump_line", "")),
    ],
)
def test_options_are_numbers_lists_or_text(option: str, value: tuple[str, object]) -> None:
    assert parsed(option) == value
