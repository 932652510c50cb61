"""GET /healthz: is all well? For a probe that asks every few seconds and shows nothing to a stranger."""

import asyncio
import shutil
from dataclasses import dataclass
from typing import Annotated

from controller.schema.layout import Model
from controller.system.scheduler import Scheduler
from recordings.write.session import DISK_FREE_MIN
from server.health.monitor import HealthMonitor
from server.http.given import given
from server.recorder.client import RecorderClient
from server.recorder.folder import RecordingsFolder
from server.rig.client import Rig

DISK_ANSWER_MAX_S = 2.0
"""Longest wait for the disk's answer."""
JOBS_AGE_MAX_S = 2.0
"""Since jobs were called last: from then on the server counts as stuck."""


class Check(Model):
    """One part, and what is wrong with it."""

    ok: bool
    detail: str = ""


class Healthz(Model):
    """All parts; `ok` (and status 200) only when every one is."""

    ok: bool
    server: Check
    """Its event loop turns, calls its jobs, and all of them work."""
    threads: Check
    """Each of them lives, turns, and has not failed within the last minute."""
    rig: Check
    """It is heard, and takes our commands."""
    recorder: Check
    """Its thread lives, the disk keeps up, a recording may begin, and the last one did not end by itself."""
    disk: Check
    """A recording could begin."""


@dataclass(frozen=True)
class Probed:
    """What is looked at."""

    scheduler: Scheduler
    monitor: HealthMonitor
    rig: Rig
    recorder: RecorderClient
    folder: RecordingsFolder


GivenProbed = Annotated[Probed, given(Probed)]


async def healthz(probed: Probed) -> Healthz:
    """Look at every part now. No path, name or value of anybody is in it."""
    parts = {
        "server": _server(probed),
        "threads": _check(not probed.monitor.of("threads"), "one hangs or has failed; the log says which"),
        "rig": _rig(probed),
        "recorder": _recorder(probed),
        "disk": await _answering_disk(probed),
    }
    return Healthz(ok=all(part.ok for part in parts.values()), **parts)


def _server(probed: Probed) -> Check:
    if probed.scheduler.age > JOBS_AGE_MAX_S:
        return Check(ok=False, detail=f"its jobs were not called for more than {JOBS_AGE_MAX_S:g} s")
    if probed.monitor.of("loop"):
        return Check(ok=False, detail="the event loop stood still within the last minute; the log says where")
    return _check(not probed.monitor.of("jobs"), "one of its jobs fails; the log says which")


def _rig(probed: Probed) -> Check:
    if probed.rig.boot() is None:
        return Check(ok=False, detail="not heard")
    return _check(not probed.rig.trouble, "it takes no command from this server; the log says why")


def _recorder(probed: Probed) -> Check:
    if not probed.recorder.worker.alive:
        return Check(ok=False, detail="its thread has ended")
    return _check(
        not probed.recorder.state().problem,
        "a recording waits for the disk, may not begin, or ended by itself; the log says why",
    )


async def _answering_disk(probed: Probed) -> Check:
    try:
        return await asyncio.wait_for(asyncio.to_thread(_disk, probed), DISK_ANSWER_MAX_S)
    except TimeoutError:
        return Check(ok=False, detail=f"the disk does not answer within {DISK_ANSWER_MAX_S:g} s")


def _disk(probed: Probed) -> Check:
    """Of a folder that the first recording will make: the disk that it will be on."""
    folder = probed.folder.store.folder
    try:
        free = shutil.disk_usage(next(place for place in (folder, *folder.parents) if place.exists())).free
    except OSError:
        return Check(ok=False, detail="the folder of the recordings cannot be read")
    return _check(free >= DISK_FREE_MIN, f"{free >> 20} MiB are free, recordings need {DISK_FREE_MIN >> 20}")


def _check(ok: bool, complaint: str) -> Check:
    return Check(ok=ok, detail="" if ok else complaint)
