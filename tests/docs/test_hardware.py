"""docs/hardware.md, and the shipped rig files, against the models and drivers that they describe."""

import re
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from controller.drivers.capture.json_udp import JsonCapture, JsonOptions
from controller.drivers.registry import capture_device, driver_class, driver_names, valve_device
from controller.errors import _WORDS
from controller.schema.layout import Model
from controller.schema.rig_file import RigFile, read_rig_file
from controller.system.origin import ROOT
from controller.virtual.firmware import compiler
from controller.virtual.peers import LATENCY
from controller.virtual.process import VirtualProcess
from controller.virtual.registry import CAPTURE_PEERS, VALVE_PEERS
from controller.virtual.rig import FAULTS
from tests.docs.blocks import EXAMPLES, blocks, elsewhere, free_port, rows_after

PAGE = ROOT / "docs" / "hardware.md"
TEXT = PAGE.read_text()
WHOLE = {"controller", "limits", "twin", "commissioned", "motion_capture.options", "valves.options"}
"""Tables whose keys other documents have."""
SHIPPED = sorted(EXAMPLES.glob("rig*.toml"))


def keys(model: type[Model], before: str = "") -> Iterator[tuple[str, type[Model], str]]:
    """Every key of a rig file, with the model and field that it is."""
    for name, field in model.model_fields.items():
        kind = field.annotation
        if before + name not in WHOLE and isinstance(kind, type) and issubclass(kind, Model):
            yield from keys(kind, f"{before}{name}.")
        else:
            yield before + name, model, name


def written(value: object) -> str:
    """As the table has it."""
    if isinstance(value, tuple):
        return ", ".join(written(one) for one in value)
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.15g}" if isinstance(value, int | float) else str(value)


def default(model: type[Model], name: str, key: str) -> str:
    field = model.model_fields[name]
    return "" if field.is_required() or key in WHOLE or field.default == {} else written(field.default)


def bounds(model: type[Model], name: str, key: str) -> str:
    """Least and most, or the words of what a text may be, of the numbers inside."""
    if key in WHOLE or key == "actuator":
        return ""
    one: dict[str, Any] = model.model_json_schema()["properties"][name]
    while one.get("type") in ("array", "object"):
        one = cast(dict[str, Any], one.get("items") or one.get("additionalProperties") or one["prefixItems"][0])
    if "pattern" in one:
        return _WORDS[one["pattern"]]
    if "enum" in one:
        return ", ".join(one["enum"])
    low = f"above {written(one['exclusiveMinimum'])}" if "exclusiveMinimum" in one else written(one.get("minimum", ""))
    high = written(one.get("maximum", ""))
    return (
        f"{low}, below {written(one['exclusiveMaximum'])}"
        if "exclusiveMaximum" in one
        else f"{low} to {high}".strip(" to")
    )


def test_the_table_has_every_key_of_a_rig_file_with_default_and_bounds() -> None:
    table = TEXT[TEXT.index("| key | default") : TEXT.index("## Every lab")]
    cells = [[cell.strip() for cell in line.split("|")] for line in table.splitlines()[2:] if line]
    said = {key.strip("`"): (found, allowed) for _, key, found, allowed, _, _ in cells}
    assert said == {key: (default(model, name, key), bounds(model, name, key)) for key, model, name in keys(RigFile)}


def test_the_table_has_everything_that_breaks_a_virtual_rig() -> None:
    said = [
        name for line, _ in rows_after(TEXT, "Type into the first terminal") for name in re.findall(r"`(\w+)", line)
    ]
    assert set(said) == set(FAULTS) | {LATENCY}
    sentence = re.search(r"A virtual rig stands for (.*?) on this machine", TEXT, re.DOTALL)
    assert sentence and set(re.findall(r"`(\w+)`", sentence[1])) == {*CAPTURE_PEERS, *VALVE_PEERS}


def test_the_two_commands_come_first_and_name_shipped_files() -> None:
    first = next(block for block in blocks(PAGE) if block.kind == "sh")
    named = [line.split("#")[0].split() for line in first.text.splitlines()]
    assert [words[:2] for words in named] == [["tendril", "virtual-rig"], ["tendril", "up"]]
    assert {ROOT / words[-1] for words in named} == {EXAMPLES / "rig.toml"}


def test_three_labs_have_rig_files_with_drivers_that_are_there() -> None:
    found = [RigFile.model_validate(tomllib.loads(block.text)) for block in blocks(PAGE) if block.kind == "toml"]
    assert [(one.motion_capture.driver, one.valves.driver) for one in found] == [
        ("natnet", "serial"),
        ("natnet", "modbus"),
        ("json", "nidaq"),
    ]
    for one in found:
        capture_device(one.motion_capture)
        valve_device(one.valves)
        assert one.valves.pressure_max <= 100e3
        actuator = one.parameters(EXAMPLES).actuator
        assert actuator.u_max * max(actuator.pressure_map) <= one.valves.pressure_max


def test_each_driver_has_a_page_that_names_all_of_its_options() -> None:
    pages = {"serial": "serial", "udp": "udp", "modbus": "modbus", "nidaq": "modbus"}
    for driver in driver_names():
        text = (ROOT / "docs" / f"{pages.get(driver, 'motion-capture')}.md").read_text()
        missing = [name for name in driver_class(driver).Options.model_fields if not re.search(rf"\b{name}\b", text)]
        assert missing == [], driver


def test_what_is_shipped_is_on_loopback_with_ports_of_its_own() -> None:
    found = [read_rig_file(file) for file in SHIPPED]
    ports = [
        value
        for one in found
        for table in (one.motion_capture, one.valves)
        for name, value in table.options.items()
        if "port" in name
    ]
    assert len({one.name for one in found}) == len(SHIPPED) and len(set(ports)) == len(ports) >= 5


@pytest.mark.process
@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_what_is_shipped_can_be_driven(file: Path, tmp_path: Path) -> None:
    text = elsewhere(file.read_text(), tmp_path)
    if 'driver = "serial"' in text and compiler() is None:
        pytest.skip("there is no C++ compiler")
    virtual = VirtualProcess(text, tmp_path)
    try:
        assert virtual.rig.motion_capture.options["server"] == "127.0.0.1"
        camera = capture_device(virtual.rig.motion_capture)
        board = valve_device(virtual.rig.valves)
        camera.open()
        board.open()
        assert any(camera.read(0.1) is not None for _ in range(20))
        camera.close()
        board.close()
        for line in ("noise 0.001", "swap 5 10", "late 0.02", "mend"):
            virtual.do(line)
    finally:
        virtual.stop()


@pytest.mark.process
def test_the_sender_of_json_is_understood() -> None:
    page = ROOT / "docs" / "motion-capture.md"
    (program,) = [block.text for block in blocks(page) if block.kind == "py"]
    port = free_port()
    program = program.replace("192.168.1.5", "127.0.0.1").replace("5005", port)
    camera = JsonCapture(JsonOptions(sender="127.0.0.1", port=int(port), local_address="127.0.0.1"))
    camera.open()
    sender = subprocess.Popen([sys.executable, "-c", program])
    try:
        until = time.monotonic() + 10.0
        while (frame := camera.read(0.1)) is None or camera.clock != "two-way":
            assert time.monotonic() < until
        assert frame.labels == ("tip",) and frame.points.tolist() == [[0.2, 0.0, 0.0]]
    finally:
        sender.kill()
        sender.wait()
        camera.close()
