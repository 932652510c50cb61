"""Recordings whose writer dies, stops or runs out of disk; a wall clock that steps."""

import os
import resource
import signal
import time
from pathlib import Path
from typing import Any

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.processes import PAUSE, held
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require, wait

ROOM = 300_000
"""What a recording may still write when the disk is called full [bytes]."""
CLOSED_MAX_S = 20.0
"""Within which a recording that failed is closed."""
HOUR = 3600.0
WATCHED = 4.0
"""For which the rig must go on after the clock stepped [s]."""
UNLIMITED = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)


def recording(scene: Scene) -> str:
    """Begin a recording, as soon as one that failed is closed; its id, once there are rows in it."""
    id: str = wait(lambda: _begun(scene), CLOSED_MAX_S, "a recording begins", 0.2)["id"]
    wait(lambda: scene.operator.status["recording"]["rows"] > 0, 20.0, "rows in the recording")
    return id


def _begun(scene: Scene) -> dict[str, Any] | None:
    """A recording that begins; None (409) while one that failed is still being closed."""
    answer = scene.operator.request("POST", "/api/recordings", name="fault")
    require(answer.is_success or answer.status_code == 409, f"no recording: {answer.status_code}, {answer.text[:200]}")
    begun: dict[str, Any] | None = answer.json() if answer.is_success else None
    return begun


def _listed(scene: Scene) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = scene.operator.ask("GET", "/api/recordings")
    return found


def recorder_killed(scene: Scene) -> Seen:
    """The recorder goes on by itself, and the next server finds it."""
    scene.track()
    id = recording(scene)
    time.sleep(1.0)
    start = time.monotonic_ns()
    os.kill(scene.server_process, signal.SIGKILL)
    observed, took = held(scene, start)
    scene.operator.reconnect()
    scene.stays_calm()
    wait(lambda: scene.operator.status["recording"]["recording"], 30.0, "the recording at the next server")
    done = scene.operator.ask("DELETE", "/api/recordings/current")
    require(done["id"] == id and not done["part_of"], f"it was cut: {done['id']} goes on after {id}")
    require(done["gaps"] == 0 and not done["holes"], f"{done['gaps']} ticks are missing")
    require(done["complete"] and not done["problem"], f"its end: {done['problem']}")
    scene.acts_again()
    return Seen(f"{observed}; {done['rows']} rows in one recording, none missing", took)


def writer_killed(scene: Scene) -> Seen:
    """The server goes on in another part with what the rig's ring holds."""
    scene.track()
    id = recording(scene)
    time.sleep(1.0)
    start = time.monotonic_ns()
    os.kill(scene.recorder_process, signal.SIGKILL)
    wait(lambda: next((one for one in _listed(scene) if one["part_of"] == id), None), 30.0, "the second part")
    rows = scene.since(start)
    require((rows["mode"] == Mode.TRACK).all(), f"left TRACK for {trace.told(rows[-1])}")
    done = scene.operator.ask("DELETE", "/api/recordings/current")
    require(done["gaps"] == 0 and not done["holes"], f"{done['gaps']} ticks are missing in the second part")
    first = wait(
        lambda: next((one for one in _listed(scene) if one["id"] == id and one["recovered"]), None), 60.0, "the first"
    )
    scene.acts_again()
    said = f"TRACK; {first['rows']} rows mended, {done['rows']} in the second part, none missing"
    return Seen(said, trace.longest_gap_ms(rows))


def recorder_stopped(scene: Scene) -> Seen:
    """What the server missed is fetched from the rig's ring."""
    scene.track()
    recording(scene)
    start = time.monotonic_ns()
    os.kill(scene.server_process, signal.SIGSTOP)
    time.sleep(PAUSE)
    os.kill(scene.server_process, signal.SIGCONT)
    observed, took = held(scene, start)
    scene.stays_calm()
    done = scene.operator.ask("DELETE", "/api/recordings/current")
    require(done["gaps"] == 0, f"{done['gaps']} ticks are missing")
    scene.acts_again()
    return Seen(f"{observed}; {done['rows']} rows recorded, none missing", took)


def disk_full(scene: Scene) -> Seen:
    """Only the files of the process that writes are limited; the rig writes none."""
    scene.track()
    id, process = recording(scene), scene.recorder_process
    mark, size = len(scene.operator.log), Path(scene.folder, "recordings", f"{id}.rrd").stat().st_size
    start = time.monotonic_ns()
    resource.prlimit(process, resource.RLIMIT_FSIZE, (size + ROOM, resource.RLIM_INFINITY))
    try:
        line = scene.operator.sees("ended by itself", mark, 20.0)
        took = (time.monotonic_ns() - start) * 1e-6
        require(scene.recorder_process == process, "the process that writes was started again")
        rows = scene.since(start)
        require((rows["mode"] == Mode.TRACK).all(), f"the rig did not go on: {trace.told(rows[-1])}")
    finally:
        resource.prlimit(process, resource.RLIMIT_FSIZE, UNLIMITED)
    scene.acts_again()
    recording(scene)
    scene.operator.ask("DELETE", "/api/recordings/current")
    return Seen(f"TRACK; page: {line}; with room again it records", took)


def clock_forward(scene: Scene) -> Seen:
    """As a time server does that was away for long."""
    return _step(scene, HOUR)


def clock_back(scene: Scene) -> Seen:
    """The same the other way."""
    return _step(scene, -HOUR)


def _step(scene: Scene, seconds: float) -> Seen:
    scene.track()
    start = time.monotonic_ns()
    for process in (scene.server_process, scene.recorder_process, scene.rig_process):
        scene.break_inside(process, step_clock=seconds)
        time.sleep(0.5)
    time.sleep(WATCHED)
    rows = scene.since(start)
    require((rows["mode"] == Mode.TRACK).all(), f"the rig went to {trace.told(rows[-1])}")
    answer = scene.operator.request("POST", "/api/command", request="e_stop")
    require(answer.is_success, f"E-STOP was answered with {answer.status_code}: {answer.text[:100]}")
    scene.until(start, (Mode.E_STOP,), 2.0)
    scene.stays_calm()
    scene.acts_again()
    for process in (scene.server_process, scene.recorder_process, scene.rig_process):
        scene.break_inside(process, step_clock=-seconds)
        time.sleep(0.5)
    return Seen("TRACK went on, E-STOP worked", trace.longest_gap_ms(rows))
