"""`tendril up` on a twin, or on a virtual rig behind real wires, and a person who operates it."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from controller.realtime.ring import CAPACITY, find_ring
from controller.schema.commissioned import STEPS
from controller.schema.rig_file import changed, noted
from controller.virtual.process import VirtualProcess
from server.campaign import trace
from server.campaign.person import Person
from server.campaign.rows.wires import WAIVED
from server.campaign.scene import EMPTY_MAX_S
from server.campaign.table import GAP
from server.campaign.waiting import Failed, require, wait
from tests.server.live_server import PATIENT
from tests.turns import VIRTUAL_RIG, turn

LIMITS = f"""
[limits]
loop_gap = {GAP}
pressures_lost = 1.0
pressure_off_time = 1.0
operator_timeout = {PATIENT["operator_timeout"]}
"""
"""Shared machines pause for 50 ms and more; a pause counts as the loop's own only beyond loop_gap, a board whose
program waits for a core fills late, and a person under test for whom it does has not gone."""
READY = 240.0
"""Longest wait for rig and server [s]: a cold cache compiles."""


class Stack(NamedTuple):
    """What runs, and who operates it."""

    name: str
    """The rig's id."""
    person: Person
    virtual: VirtualProcess | None
    rig_process: int
    server_process: int

    def drivers(self) -> dict[str, dict[str, Any]]:
        """What the page is told of the devices, by role."""
        return {one["role"]: one for one in self.person.ask("GET", "/api/drivers")["drivers"]}

    def arm(self) -> None:
        """From wherever things are to HOLD, once the devices run and the chambers are empty."""
        wait(lambda: all(one["state"] == "running" for one in self.drivers().values()), 20.0, "devices that run", 0.1)
        for request in ("e_stop", "clear"):
            self.person.command(request)
        wait(self._armed, EMPTY_MAX_S, "chambers that are empty, so that it arms", 0.1)

    def _armed(self) -> bool:
        answer = self.person.request("POST", "/api/command", request="arm")
        require(answer.is_success or "wait until it is empty" in answer.text, f"arming was refused: {answer.text}")
        return answer.is_success

    def run(self, reference: str, seconds: float = 120.0) -> dict[str, Any]:
        """Follow a reference of the library to its end; what came of it."""
        begun = self.person.ask("POST", "/api/run", reference=reference, record=False)["id"]

        def ended() -> dict[str, Any] | None:
            found = self.person.ask("GET", "/api/runs")
            return found[0] if found and found[0]["id"] == begun else None

        return wait(ended, seconds, f"the end of {reference}", 0.2)


def changes(rig: str) -> list[str]:
    """Every change of mode or request that the rig's ring still has."""
    ring = find_ring(rig)
    rows = ring.read(max(0, ring.head - CAPACITY + 1000), CAPACITY)[1]
    keys = np.column_stack([rows[key] for key in ("mode", "cause", "request_n", "request_cause")])
    at = np.flatnonzero((np.diff(keys, axis=0) != 0).any(axis=1)) + 1
    return [f"tick {rows['tick'][i]} {trace.told(rows[i])}, request {rows['request_n'][i]}" for i in at]


@contextmanager
def stack(folder: Path, text: str = "", believed: dict[str, Any] | None = None) -> Iterator[Stack]:
    """On the virtual rig of the rig file `text`; on the twin with "". Everything that it writes is in `folder`.

    `believed`: what the rig's own file says otherwise, as before a commissioning ("motion_capture.frame": {}); without,
    it is armed though it was not commissioned.
    """
    with turn(VIRTUAL_RIG) if text else nullcontext(), _started(folder, text, believed) as one:
        yield one


@contextmanager
def _started(folder: Path, text: str, believed: dict[str, Any] | None) -> Iterator[Stack]:
    folder.mkdir(parents=True, exist_ok=True)
    ready, log = folder / "up.json", (folder / "output.log").open("wb")
    own = text.replace('name = "virtual"', f'name = "virtual-{os.getpid()}"')  # another test may run one, too
    own = own if believed else WAIVED + own
    virtual = VirtualProcess(own + LIMITS, folder, log) if text else None
    if virtual and believed:
        virtual.path.write_text(noted(changed(virtual.path.read_text(), believed, "it"), virtual.path, *STEPS))
    name = virtual.rig.name if virtual else f"twin-{os.getpid()}"
    rig = [str(virtual.path)] if virtual else [name, "--loop-gap", str(GAP)]
    given = ["--rig", *rig, "--port", "0", "--no-browser", "--ready", str(ready)]
    places = {"TENDRIL_STATE": str(folder / "state"), "TENDRIL_RECORDINGS": str(folder / "recordings")}
    up = subprocess.Popen(
        [sys.executable, "-m", "server", "up", *given],
        stdout=log,
        stderr=log,
        env={**os.environ, **places, "TENDRIL_RATE_FACTOR": "100"},
    )
    try:
        wait(lambda: ready.exists() or up.poll() is not None, READY, "rig and server", 0.1)
        assert up.poll() is None, (folder / "output.log").read_text()[-2000:]
        found = json.loads(ready.read_text())
        person = Person(found["url"])
        person.operate()
        one = Stack(name, person, virtual, found["rig_process"], found["server_process"])
        try:
            yield one
        except BaseException as error:
            told = "\n  ".join(person.log[-20:])
            error.add_note(f"the page's log:\n  {told}\n{(folder / 'output.log').read_text(errors='replace')[-2000:]}")
            error.add_note(f"the rig: {'; '.join(changes(name))}")
            with suppress(Failed):
                error.add_note(f"its devices: {json.dumps(one.drivers())}")
            raise
        person.close()
    finally:
        up.send_signal(signal.SIGINT)
        up.wait(60)
        if virtual:
            virtual.stop()
        log.close()
        time.sleep(0.1)
