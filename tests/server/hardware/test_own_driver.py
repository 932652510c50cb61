"""A driver of another package, end to end: its own far end behind the simulated arm, rig, server and an operator."""

import os
from pathlib import Path

import numpy as np
import pytest

from controller.realtime.ring import find_ring
from server.campaign.waiting import wait
from tests.controller.drivers.conformance.labboard import install
from tests.server.virtual_stack import stack

pytestmark = [pytest.mark.alone, pytest.mark.keyed("controller", "docs/drivers.md", imports=False)]

LABBOARD = """
name = "virtual"
[motion_capture]
driver = "natnet"
rods = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]
options = { server = "127.0.0.1", local_address = "127.0.0.1", points = "unlabelled" }
[valves]
driver = "labboard"
chambers = [1, 0, 3, 2]
"""
TARGET, NEAR = (0.2, 0.05), 0.01
"""Where the tip is to go, and how near is there [m]."""
FILLED = 5e3
"""Of a chamber that bends the arm [Pa]."""


def test_a_driver_and_a_far_end_of_your_own_move_the_arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "package"
    package.mkdir()
    install(package)
    monkeypatch.syspath_prepend(package)
    monkeypatch.setenv("PYTHONPATH", f"{package}:{os.environ.get('PYTHONPATH', '')}".rstrip(":"))
    with stack(tmp_path / "rig", LABBOARD) as one:
        one.arm()
        valves = one.drivers()["valves"]
        assert valves["driver"] == "labboard" and valves["device"].startswith("lab board at 127.0.0.1:")
        one.person.command("follow", target=TARGET)
        ring = find_ring(one.name)
        wait(lambda: np.hypot(*(ring.newest()["p_meas"] - TARGET)) < NEAR, 20.0, "the tip at the target")
        assert ring.newest()["pressure_meas"].max() > FILLED
