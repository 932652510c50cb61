"""GET /healthz: is all well? For a probe that asks every few seconds and shows nothing to a stranger."""

import shutil

from controller.layout import Model
from recordings.session import DISK_FREE_MIN
from server.services import Services

BEAT_MAX = 2.0
"""Age of the last beat [s] from which on the server counts as stuck."""


class Check(Model):
    """One part, and what is wrong with it."""

    ok: bool
    detail: str = ""


class Healthz(Model):
    """All parts; `ok` (and status 200) only when every one is."""

    ok: bool
    server: Check
    """Its beat of 60 Hz goes on."""
    rig: Check
    """It is heard, and takes our commands."""
    recorder: Check
    """Its thread lives, and the last recording did not end by itself."""
    disk: Check
    """A recording could begin."""


def healthz(services: Services) -> Healthz:
    """Look at every part now. No path, name or value of anybody is in it."""
    parts = {
        "server": _check(services.hub.age < BEAT_MAX, f"no beat for more than {BEAT_MAX:g} s"),
        "rig": _rig(services),
        "recorder": _recorder(services),
        "disk": _disk(services),
    }
    return Healthz(ok=all(part.ok for part in parts.values()), **parts)


def _rig(services: Services) -> Check:
    if services.rig.boot() is None:
        return Check(ok=False, detail="not heard")
    return _check(not services.rig.trouble, "it takes no command from this server; the log says why")


def _recorder(services: Services) -> Check:
    if not services.recorder.alive:
        return Check(ok=False, detail="its thread has ended")
    return _check(not services.recorder.state().problem, "the last recording ended by itself; the log says why")


def _disk(services: Services) -> Check:
    try:
        free = shutil.disk_usage(services.store.folder).free
    except OSError:
        return Check(ok=False, detail="the folder of the recordings is gone")
    return _check(free >= DISK_FREE_MIN, f"{free >> 20} MiB are free, recordings need {DISK_FREE_MIN >> 20}")


def _check(ok: bool, complaint: str) -> Check:
    return Check(ok=ok, detail="" if ok else complaint)
