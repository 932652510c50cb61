"""Which devices, hosts and files the page may have the rig reach: those of its file, and those that were allowed."""

from pathlib import Path

import pytest

from controller.errors import ParameterError
from controller.schema.rig_file import parse_rig_file
from server.hardware.places import AllowedPlaces, places
from tests.server.live_server import TestServer

FILE = """name = "test"
actuator = "{actuator}"
[motion_capture]
driver = "json"
[motion_capture.options]
sender = "127.0.0.1"
port = 9
[valves]
driver = "{driver}"
[valves.options]
{options}
"""
BEFORE = FILE.format(actuator="P1", driver="serial", options='port = "/dev/ttyACM0"')


def named(text: str) -> dict[str, str]:
    return places(parse_rig_file(text, "rig.toml"))


@pytest.mark.parametrize(
    ("actuator", "driver", "options", "field", "value"),
    [
        ("P1", "serial", 'port = "/dev/watchdog"', "valves.options.port", "/dev/watchdog"),
        ("P1", "serial", 'port = "/etc/passwd"', "valves.options.port", "/etc/passwd"),
        ("P1", "serial", 'port = "socket://127.0.0.1:22"', "valves.options.port", "socket://127.0.0.1:22"),
        ("P1", "udp", 'host = "10.0.0.1"\nport = 80', "valves.options.host", "10.0.0.1"),
        ("P1", "udp", "", "valves.options.host", "192.168.1.2"),
        ("P1", "modbus", 'host = "localhost"\nport = 22', "valves.options.host", "localhost"),
        ("../secret.toml", "serial", 'port = "/dev/ttyACM0"', "actuator", "../secret.toml"),
        ("/proc/self/x.toml", "serial", 'port = "/dev/ttyACM0"', "actuator", "/proc/self/x.toml"),
    ],
)
def test_a_new_place_is_refused_by_field_and_value_unless_it_was_allowed(
    actuator: str, driver: str, options: str, field: str, value: str
) -> None:
    wanted = named(FILE.format(actuator=actuator, driver=driver, options=options))
    strict, allowing = AllowedPlaces(""), AllowedPlaces(f"nothing,{value[:-1]}*")
    for allowed in (strict, allowing):
        allowed.learn(named(BEFORE).values())
    with pytest.raises(ParameterError) as refused:
        strict.require(wanted)
    assert str(refused.value).startswith(f"{field} = {value}: ") and "/dev/ttyACM0" in str(refused.value)
    allowing.require(wanted)


def test_what_the_file_named_numbers_and_files_beside_it_may_be_changed_to_and_back() -> None:
    allowed = AllowedPlaces("")
    allowed.learn(named(BEFORE).values())
    for actuator, options in (
        ("P1", 'port = "/dev/ttyACM0"\nbaud = 115200'),
        ("P2", 'port = "/dev/ttyACM0"'),
        ("identified.toml", 'port = "/dev/ttyACM0"'),
    ):
        allowed.require(named(FILE.format(actuator=actuator, driver="serial", options=options)))


def test_the_page_writes_no_new_place_into_the_file(server: TestServer, tmp_path: Path) -> None:
    operator, file = server.operator(), tmp_path / "rig.toml"
    file.write_text(BEFORE)
    server.services.settings.rig_file, server.services.settings.restarts = file, tmp_path / "restarts.json"
    for wrong in ("/dev/watchdog", "/etc/passwd"):
        refused = operator.put("/api/rig-file", json={"text": BEFORE.replace("/dev/ttyACM0", wrong)})
        assert (refused.status_code, wrong in refused.text, "at the start" in refused.text) == (422, True, True)
    assert file.read_text() == BEFORE
    same = BEFORE + "baud = 115200\n"
    taken = operator.put("/api/rig-file", json={"text": same})
    assert (taken.is_success, file.read_text()) == (True, same), taken.text
