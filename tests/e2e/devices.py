"""A virtual rig for browser tests: what it is made of, and `tendril up` that drives it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from controller.schema.rig_file import noted
from controller.virtual.process import VirtualProcess
from tests.e2e.product import Product
from tests.turns import VIRTUAL_RIG, turn

FILE = """
name = "devices-{number}"
arm_uncommissioned = true
[motion_capture]
driver = "natnet"
rods = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]
options = {{ server = "127.0.0.1", local_address = "127.0.0.1", points = "unlabelled" }}
[valves]
driver = "modbus"
options = {{ host = "127.0.0.1" }}
[limits]
loop_gap = 0.4
operator_timeout = 5.0
measurement_old = 1.0
measurement_lost = 5.0
pressures_lost = 5.0
pressure_off_time = 5.0
[commissioned]
drivers = "both run, as a test says"
"""
"""Patient: a machine that is shared gives camera, valves and page their turn late, a page under axe last of all."""


@contextmanager
def driven(folder: Path) -> Iterator[tuple[Product, VirtualProcess]]:
    """Both running, and ended in order."""
    with turn(VIRTUAL_RIG), (folder / "virtual.log").open("wb") as output:
        virtual = VirtualProcess(FILE.format(number=os.getpid()), folder, output)
        virtual.path.write_text(noted(virtual.path.read_text(), virtual.path, "drivers"))
        try:
            with Product(folder, rig_file=virtual.path) as product:
                yield product, virtual
        finally:
            virtual.stop()
