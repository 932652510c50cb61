"""A rig file that is wrong is refused in one line with file, field, value and bound, by both commands that take one."""

import os
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import ValidationError

from controller.errors import TendrilError
from controller.schema.rig_file import SIZE_MAX
from controller.system.origin import ROOT
from controller.virtual.rig import run_virtual_rig
from server.cli.rig_files import rig_parameters

GOOD = (ROOT / "docs" / "examples" / "rig.toml").read_text()
FREE = GOOD.replace("15100", "0").replace("15110", "0").replace("15020", "0")


def up(path: Path) -> None:
    rig_parameters(path, {})


def virtual(path: Path) -> None:
    with open(os.devnull) as nothing:
        run_virtual_rig(path, "", None, nothing)


BOTH = {"up": up, "virtual-rig": virtual}
MISTAKES = [
    ('name = "virtual"', 'name = "my rig"', "name = my rig: 1 to 40 letters"),
    ('actuator = "P1"', 'actuater = "P1"', "actuater = P1: Extra inputs"),
    ('actuator = "P1"', 'actuator = "P9"', "actuator = 'P9' is not one of P1, P2, P3 or a .toml file"),
    ('actuator = "P1"', 'actuator = "mine.toml"', "mine.toml cannot be read"),
    ("rods = [5, 10]", "rods = [5, 5]", "motion_capture: rods = [5, 5] names one twice"),
    ("rods = [5, 10]", "rods = [5, 11]", "motion_capture.rods.1 = 11: Input should be less than or equal to 10"),
    ("rods = [5, 10]", 'rods = "tip"', "motion_capture.rods = tip: "),
    ("tip = 10 }", "tip = 9 }", "motion_capture: labels name rod 9, which rods = [5, 10] does not"),
    ("[0.0, 0.0, 1.0]]", "[2.0, 0.0, 0.0]]", "axes = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]] do not span a plane"),
    ("[0.0, 0.0, 1.0]]", "[0.0, nan, 1.0]]", "motion_capture.frame.axes.1.1 = nan: "),
    ("command_port = 15100", "command_port = 70000", "motion_capture.options.command_port = 70000: "),
    ("command_port = 15100", "comand_port = 1510", "motion_capture.options.comand_port = 1510: Extra inputs"),
    ('driver = "modbus"', 'driver = "festo"', "valves.driver = festo: "),
    ('driver = "modbus"', "driver = 3", "valves.driver = 3: "),
    ('driver = "modbus"', 'driver = "natnet"', "valves.driver = natnet"),
    ("chambers = [0, 1, 2, 3]", "chambers = [0, 1, 1, 3]", "chambers = [0, 1, 1, 3] names a channel twice"),
    ("chambers = [0, 1, 2, 3]", "chambers = [0, 1, 2, 16]", "valves.chambers.3 = 16: Input should be less than 16"),
    ("chambers = [0, 1, 2, 3]", 'command = "air"', "valves.command = air: Input should be 'pressure' or 'opening'"),
    ("port = 15020", "port = 70000", "valves.options.port = 70000: Input should be less than or equal to 65535"),
    ("port = 15020", "port = { a = 1 }", "valves.options.port: is neither a text, a number"),
    ("[valves]", "[valve]", "valves.driver: Field required"),
    ("[valves]", "[valves", "is not TOML: "),
]


def test_limits_of_the_command_stand_in_place_of_those_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(GOOD + "\n[limits]\nloop_gap = 0.3\nserver_hold = 0.4\n")
    asked = rig_parameters(path, {"loop_gap": 0.2, "operator_timeout": 1.5}).limits
    assert (asked.loop_gap, asked.operator_timeout, asked.server_hold) == (0.2, 1.5, 0.4)
    with pytest.raises(ValidationError, match="operator_timeout\n  Input should be less than or equal to 10"):
        rig_parameters(path, {"operator_timeout": 11.0})


@pytest.mark.parametrize("command", BOTH)
@pytest.mark.parametrize(("good", "bad", "text"), MISTAKES, ids=[bad for _, bad, _ in MISTAKES])
def test_each_mistake_is_named(command: str, good: str, bad: str, text: str, tmp_path: Path) -> None:
    assert good in GOOD
    path = tmp_path / "rig.toml"
    path.write_text(GOOD.replace(good, bad, 1))
    with pytest.raises(TendrilError) as refused:
        BOTH[command](path)
    said = str(refused.value)
    assert str(path) in said and text in said and "\n" not in said


def a_folder(path: Path) -> None:
    path.mkdir()


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


NO_FILES: dict[str, tuple[Callable[[Path], object], str]] = {
    "nothing": (lambda path: None, "No such file"),
    "folder": (a_folder, "it is a folder"),
    "pipe": (a_pipe, "it is a pipe"),
    "link": (lambda path: path.symlink_to(ROOT / "docs" / "examples" / "rig.toml"), "it is a link"),
    "huge": (lambda path: path.write_text("#" * (SIZE_MAX + 1)), f"{SIZE_MAX} are the most"),
    "binary": (lambda path: path.write_bytes(b"\xff\xfe\x00"), "is not text"),
    "empty": (lambda path: path.write_text(""), "motion_capture: Field required"),
    "deep": (lambda path: path.write_text("a=" + "[" * 5000), "nested too deeply"),
    "a deep key": (lambda path: path.write_text("a" + ".a" * 30_000 + "=1"), "more than 10 parts"),  # took 26 s
}


@pytest.mark.parametrize("command", BOTH)
@pytest.mark.parametrize("what", NO_FILES)
def test_what_is_no_rig_file_is_said(command: str, what: str, tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    make, text = NO_FILES[what]
    make(path)
    with pytest.raises(TendrilError, match=text) as refused:
        BOTH[command](path)
    assert str(path) in str(refused.value)


@pytest.mark.parametrize(
    ("kind", "table", "option"),
    [(socket.SOCK_DGRAM, "motion_capture", "command_port"), (socket.SOCK_STREAM, "valves", "port")],
)
def test_an_address_that_is_taken_is_named(kind: int, table: str, option: str, tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind(("127.0.0.1", 0))
        if kind == socket.SOCK_STREAM:
            taken.listen()
        port = taken.getsockname()[1]
        path.write_text(FREE.replace(f"\n{option} = 0", f"\n{option} = {port}", 1))
        before = threading.active_count()
        with pytest.raises(TendrilError, match=rf"rig.toml: {table} cannot begin at .*{option} = {port}"):
            virtual(path)
    assert threading.active_count() == before


@pytest.mark.parametrize(
    ("option", "text"),
    [
        ("server", r"motion_capture cannot begin at server = 192\.0\.2\.7"),
        ("host", r"valves\.options\.host = 192\.0\.2\.7: a virtual rig is at 127\.0\.0\.1"),
    ],
)
def test_an_address_of_another_machine_is_named(option: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(FREE.replace(f'\n{option} = "127.0.0.1"', f'\n{option} = "192.0.2.7"'))
    with pytest.raises(TendrilError, match=text):
        virtual(path)


def test_a_virtual_board_never_takes_the_place_of_what_is_there(tmp_path: Path) -> None:
    real, path = tmp_path / "ttyACM0", tmp_path / "rig.toml"
    link = tmp_path / "usb-board"
    link.symlink_to(real)
    real.touch()
    text = (ROOT / "docs" / "examples" / "rig-serial.toml").read_text().replace("15101", "0").replace("15111", "0")
    for place in (real, link):
        path.write_text(text.replace("/tmp/tendril-board", str(place)))
        with pytest.raises(TendrilError, match=rf"valves.options.port = {place} is there already"):
            virtual(path)
    assert real.is_file() and link.is_symlink()
