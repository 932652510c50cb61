import pytest
from typer.testing import CliRunner

from controller.drivers.registry import capture_class, valve_class
from controller.errors import ParameterError
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
    assert "yes    vents when told" in done.output and "yes    survives a loss" in done.output
    done = run.invoke(app, ["check", "udp", "-o", "host=127.0.0.1", "-o", "port=1", "-o", "connect_time=0.05"])
    assert done.exit_code == 1
    assert "no     keeps to its time" in done.output and "-      survives a loss" in done.output


def test_what_cannot_be_checked_is_said() -> None:
    assert "there are" in str(run.invoke(app, ["check", "nothing"]).exception)
    for driver in ("nidaq", "lsl"):
        assert f"driver {driver} has no virtual peer" in run.invoke(app, ["check", driver, "--peer"]).output
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
