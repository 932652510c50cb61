"""The link between server and rig: cut, stalled, late, lossy."""

import time

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.processes import held
from server.campaign.proxy import Proxy
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require

AWAY = 3.0
"""For which the link is gone [s]."""
BAD = 4.0
"""For which the link is bad before someone presses E-STOP [s]."""
SAFE = (Mode.TRACK, Mode.HOLD)


def _link(scene: Scene) -> Proxy:
    require(scene.proxy, "the link has no proxy")
    assert scene.proxy is not None
    return scene.proxy


def cut(scene: Scene) -> Seen:
    """Connections are closed, new ones refused."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    _link(scene).cut()
    observed, took = held(scene, start)
    line = scene.operator.sees("the rig is gone", mark)
    time.sleep(max(0.0, AWAY - (time.monotonic_ns() - start) * 1e-9))
    return _mended(scene, f"{observed}; page: {line}", took)


def silent(scene: Scene) -> Seen:
    """Everything waits, and then comes at once: presence too, and it is old."""
    scene.track()
    start = time.monotonic_ns()
    _link(scene).weather.stalled = True
    observed, took = held(scene, start)
    time.sleep(AWAY)
    return _mended(scene, observed, took)


def delayed(scene: Scene) -> Seen:
    """A round trip takes longer than the server waits for an answer."""
    scene.track()
    _link(scene).weather.delay = 0.3
    return _stop_in_time(scene)


def lossy(scene: Scene) -> Seen:
    """Nothing is lost on TCP, but it comes late."""
    scene.track()
    _link(scene).weather.loss = 0.2
    return _stop_in_time(scene)


def _mended(scene: Scene, observed: str, took: float) -> Seen:
    _link(scene).mend()
    scene.stays_calm()
    scene.operator.reconnect()
    require(scene.mode == Mode.HOLD, f"in {scene.mode.name} after the link came back")
    scene.acts_again()
    return Seen(f"{observed}; HOLD when the link was back", took)


def _stop_in_time(scene: Scene) -> Seen:
    """Neither more nor less than TRACK or HOLD meanwhile, and an E-STOP gets through, answered or not."""
    start = time.monotonic_ns()
    time.sleep(BAD)
    rows = scene.since(start)
    modes = [Mode(mode) for mode in dict.fromkeys(rows["mode"].tolist())]
    require(all(mode in SAFE for mode in modes), f"went through {', '.join(mode.name for mode in modes)}")
    require(modes in ([Mode.TRACK], [Mode.TRACK, Mode.HOLD], [Mode.HOLD]), "moved again after HOLD")
    stop = time.monotonic_ns()
    scene.operator.request("POST", "/api/command", request="e_stop")
    row = scene.until(stop, (Mode.E_STOP,), 10.0)
    _link(scene).mend()
    scene.stays_calm()
    scene.acts_again()
    return Seen(f"{' then '.join(mode.name for mode in modes)}; {trace.told(row)}", (row["t_ns"] - stop) * 1e-6)
