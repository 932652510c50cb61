"""Which accepted steps of a rig file stand: until a line under them changes, wherever that is edited."""

from pathlib import Path
from typing import Any

import pytest

from controller.schema.actuator import PRESETS
from controller.schema.commissioned import GATE, RESTS_ON, STANDS_ON, STEPS, StepName
from controller.schema.rig_file import RigFile, changed, noted, parse_rig_file
from tests.docs.blocks import EXAMPLES, rows_after

PLAIN = """
actuator = "P1"
[motion_capture]
driver = "natnet"
rods = [5, 10]
labels = { middle = 5, tip = 10 }
options = { server = "127.0.0.1" }
frame = { measured = true }
[valves]
driver = "serial"
options = { port = "/dev/ttyNONE" }
measured = true
"""
OTHER: dict[str, Any] = {
    "motion_capture.driver": "json",
    "motion_capture.options": {"server": "127.0.0.2"},
    "motion_capture.rods": [4, 5, 10],
    "motion_capture.labels": {"middle": 10, "tip": 5},
    "motion_capture.frame": {"axes": [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], "measured": True},
    "valves.driver": "modbus",
    "valves.options": {"port": "/dev/ttyOTHER"},
    "valves.chambers": [1, 0, 2, 3],
    "valves.command": "opening",
    "valves.measured": False,
    "valves.loop": {"inflate_gain": 1e-6},
    "controller.dead_time": 0.011,
    "controller.pneumatic_lag": 0.2,
    "actuator": "P2",
}
"""Another value for each line on which a step stands."""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "rig.toml"


def accepted(path: Path, *steps: StepName, text: str = PLAIN) -> str:
    """The rig file with these steps accepted."""
    return noted(changed(text, {"commissioned": dict.fromkeys(steps, "yes")}, "it"), path, *steps)


def commissioned(text: str, path: Path) -> str:
    hardware = parse_rig_file(text, "it").parameters(path.parent).hardware
    assert hardware is not None
    return hardware.commissioned


def withdrawn(text: str, path: Path) -> dict[StepName, str]:
    return parse_rig_file(text, "it").withdrawn(path.parent)


def resting_on(step: StepName) -> set[StepName]:
    return {step} | {other for one in STEPS if step in RESTS_ON[one] for other in resting_on(one)}


@pytest.mark.parametrize("field", OTHER)
def test_a_line_that_changes_withdraws_what_stands_on_it_and_all_that_rests_on_that(field: str, path: Path) -> None:
    text = accepted(path, *STEPS)
    assert withdrawn(text, path) == {}
    edited = changed(text, {field: OTHER[field]}, "it")
    found, standing_on = withdrawn(edited, path), {step for step in STEPS if field in STANDS_ON[step]}
    assert set(found) == {other for step in standing_on for other in resting_on(step)}
    assert all(field in found[step] for step in standing_on)
    assert commissioned(edited, path) == ("missing" if set(found) & set(GATE) else "accepted")


def test_every_line_on_which_a_step_stands_is_tried() -> None:
    assert set(OTHER) == {field for fields in STANDS_ON.values() for field in fields}


@pytest.mark.parametrize("missing", GATE)
def test_each_of_the_four_is_needed_to_arm(missing: StepName, path: Path) -> None:
    text = accepted(path, *(step for step in STEPS if step != missing))
    assert commissioned(text, path) == "missing"
    assert commissioned(f"arm_uncommissioned = true\n{text}", path) == "waived"
    assert commissioned(accepted(path, *GATE), path) == "accepted"


def test_what_says_the_same_withdraws_nothing(path: Path) -> None:
    text = accepted(path, *STEPS)
    edited = text.replace("rods = [5, 10]", "rods = [ 5,10 ]  # the middle and the tip")
    edited = changed(edited, {"motion_capture.frame": {"origin": [0, 0], "measured": True}}, "it")
    assert edited != text and withdrawn(edited, path) == {}
    back = changed(changed(text, {"valves.chambers": [1, 0, 2, 3]}, "it"), {"valves.chambers": [0, 1, 2, 3]}, "it")
    assert withdrawn(back, path) == {}


def test_an_actuator_is_known_by_its_numbers_not_by_its_name(path: Path) -> None:
    softer = PRESETS["P1"].model_copy(update={"k": tuple(0.8 * k for k in PRESETS["P1"].k)})
    text = accepted(path, *STEPS)
    table = RigFile.model_validate(parse_rig_file(text, "it").model_dump() | {"actuator": softer.model_dump()})
    assert set(table.withdrawn(path.parent)) == {"identify", "closed_loop"}


def test_steps_without_marks_do_not_stand_and_steps_that_are_gone_leave_none(path: Path) -> None:
    text = changed(PLAIN, {"commissioned": dict.fromkeys(STEPS, "by version 0.2")}, "it")
    assert set(withdrawn(text, path)) == set(STEPS) and commissioned(text, path) == "missing"
    left = noted(changed(accepted(path, *STEPS), {"commissioned": {"drivers": "yes"}}, "it"), path)
    assert set(parse_rig_file(left, "it").stands_on) == {"drivers"}


def test_the_documents_say_what_each_step_stands_on() -> None:
    rows = rows_after((EXAMPLES.parent / "commissioning.md").read_text(), "An edit withdraws")
    told = {step: cells for names, cells in rows for step in names.replace("`", "").split(", ")}
    for step in STEPS:
        for field in STANDS_ON[step]:
            assert field.rsplit(".", 1)[-1] in told[step], (step, field)
