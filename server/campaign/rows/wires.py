"""Devices that fail on their own wires: the rig drives a virtual rig, which is told to break."""

import os
import signal
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from controller.schema.modes import Cause, Law, Mode
from server.campaign import trace
from server.campaign.scene import CIRCLE, Scene
from server.campaign.table import RESTART_MS
from server.campaign.waiting import Seen, before_the_fault, require, wait
from server.log.events import words

NAMED = """
name = "virtual"
[motion_capture]
driver = "natnet"
rods = [6, 10]
labels = { six = 6, tip = 10 }
options = { server = "127.0.0.1", local_address = "127.0.0.1", points = "labelled" }
[motion_capture.frame]
axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
origin = [0.1, -0.2]
"""
"""Markers that the camera knows by name."""
SERIAL = f"""{NAMED}
[valves]
driver = "serial"
chambers = [2, 3, 0, 1]
"""
"""Our own firmware on a pseudo-terminal."""
UDP = f"""{NAMED}
[valves]
driver = "udp"
chambers = [2, 3, 0, 1]
options = {{ host = "127.0.0.1" }}
"""
"""A target as Simulink or LabVIEW make one."""
MODBUS = """
name = "virtual"
[motion_capture]
driver = "natnet"
rods = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]
options = { server = "127.0.0.1", local_address = "127.0.0.1", points = "unlabelled" }
[valves]
driver = "modbus"
options = { host = "127.0.0.1" }
"""
"""Markers without names, and a Festo terminal."""
ON_SERIAL = (
    "serial-cut",
    "board-reset",
    "board-hung",
    "half-frame",
    "answers-late",
    "natnet-stopped",
    "markers-swapped",
    "markers-ghosts",
)
ON_OTHERS = {"modbus-timeout": MODBUS, "udp-silent": UDP, "markers-unnamed-swap": MODBUS}
WAIVED = "arm_uncommissioned = true\n"
"""A virtual rig is as its file says."""
RIGS = {name: WAIVED + rig for name, rig in (dict.fromkeys(ON_SERIAL, SERIAL) | ON_OTHERS).items()}
RIGS["uncommissioned"] = UDP
"""The virtual rig that each of these faults needs."""

OUT = 2.0
"""For which a device is gone, or wrong [s]."""
SLACK = 3.0
"""After which a reaction is not waited for any more [s]; its limit is judged by the ring's own times."""
EMPTY = 5e3
"""A chamber below this has been vented [Pa]."""
ASKED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("/api/command", {"request": "arm"}),
    ("/api/command", {"request": "follow", "target": [0.2, 0.0]}),
    ("/api/run", {"reference": CIRCLE, "laps": 1}),
)
"""What would set a rig in motion, arming first."""
NEAR = 0.03
"""The tip that the rig believes in stays this near to the plant's own course [m]."""


def serial_cut(scene: Scene) -> Seen:
    """The port is gone."""
    return _latched(scene, ("unplug valves", "plug valves"), Mode.E_STOP, Cause.PRESSURES_LOST)


def board_reset(scene: Scene) -> Seen:
    """It is there again at once, and drives nothing."""
    return _latched(scene, ("reset", "mend"), Mode.E_STOP, Cause.PRESSURES_LOST)


def board_hung(scene: Scene) -> Seen:
    """The port is there, and no one answers."""
    return _latched(scene, ("freeze", "thaw"), Mode.E_STOP, Cause.PRESSURES_LOST)


def modbus_timeout(scene: Scene) -> Seen:
    """The connection is there, and no one answers."""
    return _latched(scene, ("freeze", "thaw"), Mode.E_STOP, Cause.PRESSURES_LOST)


def udp_silent(scene: Scene) -> Seen:
    """There is no connection that could break, and no command to vent comes through: the target has to do it alone."""
    start = time.monotonic_ns()
    seen = _latched(scene, ("freeze", "thaw"), Mode.E_STOP, Cause.PRESSURES_LOST)
    rows = scene.since(start)
    sensed = rows["pressure_meas"][(rows["mode"] == Mode.E_STOP) & (rows["cause"] == Cause.PRESSURES_LOST)]
    fresh = sensed[(sensed != sensed[0]).any(axis=1)]
    require(len(fresh), "no pressures came back")
    most = [1e-3 * float(pressures.max()) for pressures in (sensed[0], fresh[0])]
    require(1e3 * most[1] < EMPTY, f"the target had not vented by itself: {most[1]:.0f} kPa in a chamber")
    return seen._replace(observed=f"{seen.observed}; from {most[0]:.0f} to {most[1]:.0f} kPa by itself")


def camera_stopped(scene: Scene) -> Seen:
    """Its program is closed."""
    return _latched(scene, ("unplug camera", "plug camera"), Mode.FAULT, Cause.MEASUREMENT_LOST)


def markers_swapped(scene: Scene) -> Seen:
    """Names are believed, so only the way that a marker cannot have gone shows it."""
    return _latched(scene, ("swap 6 10", "mend"), Mode.FAULT, Cause.MEASUREMENT_JUMPED)


def half_frame(scene: Scene) -> Seen:
    """One answer of 500 a second."""
    before = _rejected(scene)
    seen = _unmoved(scene, ("half", "mend"))
    require(_rejected(scene) > before, "the half frame was not counted")
    return seen


def answers_late(scene: Scene) -> Seen:
    """Each after the driver's timeout: used and counted, and the device's state says so."""
    said: dict[str, Any] = {}
    seen = _unmoved(scene, ("hold_back 0.015", "mend"), lambda: said.update(_late(scene)))
    require(said["late"] > 0, "no late answer was counted")
    text = said["detail"]
    require("timeout is 10 ms" in text, f"the device's state: {text}")
    return seen._replace(observed=f"{seen.observed}; {text}, {said['late']} of them")


def ghosts(scene: Scene) -> Seen:
    """Points without names, anywhere."""
    return _unmoved(scene, ("ghosts 8", "mend"))


def unnamed_swapped(scene: Scene) -> Seen:
    """Who is who is found again in every frame."""
    return _unmoved(scene, ("swap 3 10", "mend"))


def uncommissioned(scene: Scene) -> Seen:
    """It is the rig that refuses, and the one after it does, too."""
    before = _refuses(scene)
    boot = scene.boot
    os.kill(scene.rig_process, signal.SIGKILL)
    wait(lambda: scene.boot not in (0, boot), RESTART_MS * 1e-3, "the next rig")
    after = _refuses(scene)
    return Seen(f"{before.observed}; the same of the next rig", max(before.reaction_ms, after.reaction_ms))


def _refuses(scene: Scene) -> Seen:
    """All that sets it in motion, in closed loop and in open loop."""
    operator = scene.operator
    with before_the_fault():
        operator.reconnect()
        scene.wait_for_devices()
        for request in ("e_stop", "clear"):
            operator.command(request)
    start, slowest, told = time.monotonic_ns(), 0, ""
    for law in (Law.FF_PI, Law.OPEN_LOOP):
        operator.ask("PATCH", "/api/settings", changes={"law": law})
        for path, body in ASKED:
            asked = time.monotonic_ns()
            answer = operator.request("POST", path, **body)
            slowest = max(slowest, time.monotonic_ns() - asked)
            require(400 <= answer.status_code < 500, f"{body} was answered with {answer.status_code}: {answer.text}")
            told = told or answer.json()["detail"]
    require("not all accepted" in told, f"arming was refused with {told!r}")
    rows = scene.since(start)
    left = rows[rows["mode"] != Mode.VENTED]
    require(not len(left), f"left VENTED for {', '.join(trace.told(row) for row in left[:1])}")
    require(not rows["pressure_cmd"].any(), "pressure was commanded")
    return Seen(told, slowest * 1e-6)


def _latched(scene: Scene, lines: tuple[str, str], mode: Mode, cause: Cause) -> Seen:
    """Break and mend: the rig has to go to `mode` because of `cause`, and stay there until it is cleared."""
    assert scene.virtual is not None
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    scene.virtual.do(lines[0])
    try:
        row = scene.until(start, (mode,), SLACK)
        line = scene.operator.sees(f"rig: {words(mode)}", mark)
        time.sleep(max(0.0, OUT - (time.monotonic_ns() - start) * 1e-9))
    finally:
        scene.virtual.do(lines[1])
    require(row["cause"] == cause, f"{trace.told(row)} instead of {cause.name}")
    scene.stays_calm()
    require(scene.mode == mode, f"in {scene.mode.name} though no one cleared it")
    scene.acts_again()
    return Seen(f"{trace.told(row)}, latched; page: {line}", (row["t_ns"] - start) * 1e-6)


def _unmoved(scene: Scene, lines: tuple[str, str], look: Callable[[], None] = lambda: None) -> Seen:
    """Break for a while: the rig has to go on as if nothing were. `look` is called before it is mended."""
    assert scene.virtual is not None
    scene.track()
    start = time.monotonic_ns()
    scene.virtual.do(lines[0])
    time.sleep(OUT)
    look()
    scene.virtual.do(lines[1])
    rows = scene.since(start)
    require((rows["mode"] == Mode.TRACK).all(), f"left TRACK for {trace.told(rows[-1])}")
    off = np.hypot(*(rows["p_meas"] - rows["p_hat"]).T)
    require(np.nanmax(off) < NEAR, f"the tip was seen {1e3 * np.nanmax(off):.0f} mm from where the observer has it")
    stood = 1e-6 * float(np.diff(rows["t_ns"]).max())
    return Seen(f"TRACK goes on; the measured tip within {1e3 * np.nanmax(off):.0f} mm of the observer's", stood)


def _valves(scene: Scene) -> dict[str, Any]:
    drivers = scene.operator.ask("GET", "/api/drivers")["drivers"]
    return next(one for one in drivers if one["role"] == "valves")


def _late(scene: Scene) -> dict[str, Any]:
    """The valves' state once it says that answers are late: the rig tells it once a second."""

    def looked() -> dict[str, Any] | None:
        valves = _valves(scene)
        return valves if valves["detail"].startswith("answers come after ") else None

    return wait(looked, SLACK, "late answers in the valves' state", 0.1)


def _rejected(scene: Scene) -> int:
    drivers = scene.operator.ask("GET", "/api/drivers")["drivers"]
    return sum(one["rejected"] + one["lost"] for one in drivers)
