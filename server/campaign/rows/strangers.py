"""Strangers at the rig's port who forge, answer in its place, keep silent, flood and repeat: nothing comes of it.

Each attack is made by four at once: a client, a peer and a router of zenoh without the key, and one who got past the
session, which no one without the key does, so that what is signed has to hold alone; a flood by the first three.
"""

import base64
import contextlib
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from controller.errors import RigHeld, TendrilError
from controller.link.asker import Asker
from controller.link.guard import password
from controller.link.keys import Keys, open_session
from controller.link.seal import SEAL_BYTES
from controller.schema.layout import to_record
from controller.schema.messages import Command, TwinFaults
from controller.schema.modes import Mode, Request
from controller.system.keys import read_key
from server.campaign import trace
from server.campaign.scene import Scene
from server.campaign.stranger import AttackPlan, Message, Way
from server.campaign.waiting import Seen, require, wait

WATCHED = 1.5
"""For which the operator drags under the attack before pressing E-STOP [s]."""
CALM = 0.7
"""For which nothing may move after it, while the attack goes on [s]."""
AHEAD = 60_000
"""Ticks by which a forged row is ahead."""
BEHIND = 1400
"""Ticks by which the page may lag behind the rig's ring on a busy machine: one that froze lags by more."""
IDLE = 200
"""Connections of a flood that say nothing."""


def forged_row(scene: Scene) -> Seen:
    """A minute ahead, in another mode."""
    return _under(scene, _plan(scene, "forge"))


def command_key(scene: Scene) -> Seen:
    """They answer as a rig would, that everything was refused."""
    return _under(scene, _plan(scene, "answer"))


def silent_queryable(scene: Scene) -> Seen:
    """They take every question and never answer."""
    return _under(scene, _plan(scene, "keep_silent"))


def flood(scene: Scene) -> Seen:
    """Thousands of messages a second on every key, and connections that say nothing."""
    plan = _plan(scene, "flood")
    keyless = [way for way in plan.ways if not way.password]  # who has a session may ask, and each answer takes time
    with _idle(scene.endpoint):
        return _under(scene, plan.model_copy(update={"ways": keyless}))


def replayed(scene: Scene) -> Seen:
    """Sealed messages of a server with the key, E-STOP among them, once more and as they were."""
    return _under(scene, _plan(scene, "repeat").model_copy(update={"recorded": tuple(_recorded(scene))}))


def _plan(scene: Scene, attack: str) -> AttackPlan:
    past = Way(mode="peer", password=password(read_key(scene.key)))
    return AttackPlan(
        attack=attack,
        ways=[Way(mode="client"), Way(mode="peer"), Way(mode="router"), past],
        endpoint=scene.endpoint,
        tls=scene.tls,
        rig=scene.rig,
        boot=scene.boot,
        rows=base64.b64encode(_forged(scene).tobytes()),
    )


def _under(scene: Scene, plan: AttackPlan) -> Seen:
    """The operator drags, records and stops under the attack, as if there was none."""
    scene.drag()
    recording = scene.operator.ask("POST", "/api/recordings", name="stranger")["id"]
    printed = len(scene.output())
    with _strangers(scene.folder / "strangers.json", plan) as rounds:
        start = time.monotonic_ns()
        _page_tells_the_truth(scene)
        took = _stops(scene, start)
        scene.stays_calm(CALM)
    require(rounds["least"] > 0, "a stranger did not even try")
    require("Traceback" not in scene.output()[printed:], "rig or server printed a traceback")
    done = scene.operator.ask("DELETE", "/api/recordings/current")
    require(done["id"] == recording and done["gaps"] == 0 and not done["holes"], f"{done['gaps']} ticks are missing")
    went = f"{rounds['all']} rounds: FOLLOW went on, E_STOP as asked; {done['rows']} rows recorded, none missing"
    return Seen(went, took)


@contextmanager
def _strangers(file: Path, plan: AttackPlan) -> Iterator[dict[str, int]]:
    """At work within the context; how many rounds they made is there after it."""
    file.write_text(plan.model_dump_json())
    command = [sys.executable, "-m", "server.campaign.stranger", str(file)]
    rounds = {"least": 0, "all": 0}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin and process.stdout
        try:
            require(process.stdout.readline() == "begun\n", "the strangers could not begin")
            yield rounds
            process.stdin.close()
            rounds["least"], rounds["all"] = map(int, process.stdout.read().split())
        finally:
            process.kill()


def _page_tells_the_truth(scene: Scene) -> None:
    end = time.monotonic() + WATCHED
    while time.monotonic() < end:
        time.sleep(0.1)
        frame, ring = scene.operator.frame, trace.newest(scene.rig)
        require(frame is not None, "the page shows nothing")
        assert frame is not None
        lag = int(ring["tick"]) - int(frame["tick"])
        shown = f"the page shows {trace.told(frame)}, the rig is in {trace.told(ring)}"
        require(frame["mode"] == Mode.FOLLOW, shown)
        require(0 <= lag < BEHIND, f"the page is {lag} ticks behind the rig")


def _stops(scene: Scene, start: int) -> float:
    """Nothing but FOLLOW since `start`, then an E-STOP that is taken, done and shown; how long it took [ms]."""
    rows = scene.since(start)
    modes = [Mode(mode).name for mode in dict.fromkeys(rows["mode"].tolist())]
    require(modes == ["FOLLOW"], f"went through {', '.join(modes)}")
    pressed = time.monotonic_ns()
    answer = scene.operator.request("POST", "/api/command", request="e_stop")
    require(answer.is_success, f"E-STOP was answered with {answer.status_code}: {answer.text[:200]}")
    row = scene.until(pressed, (Mode.E_STOP,), 5.0)
    wait(lambda: scene.operator.shows(Mode.E_STOP, pressed), 5.0, "E_STOP on the page")
    scene.operator.dragging = False
    return float(row["t_ns"] - pressed) * 1e-6


def _forged(scene: Scene) -> np.ndarray:
    rows = np.tile(trace.newest(scene.rig), 10)
    rows["tick"] += AHEAD + np.arange(10)
    rows["t_ns"] += 1_000_000 * (AHEAD + np.arange(10))
    rows["mode"] = Mode.TRACK
    return rows


def _recorded(scene: Scene) -> list[Message]:
    """What a second server with the key sent to the rig just now: opening, E-STOP, faults and good-bye."""
    found: list[Message] = []
    keys, key = Keys(scene.rig), read_key(scene.key)
    link = open_session(key=key, connect=scene.endpoint, tls=scene.tls)

    class Tap:
        """Keeps what is sealed."""

        def get(self, expression: str, *, payload: bytes, attachment: bytes, **more: Any) -> Any:
            if len(attachment) == SEAL_BYTES:
                encoded = base64.b64encode(payload), base64.b64encode(attachment)
                found.append(Message(key=expression, payload=encoded[0], seal=encoded[1]))
            return link.get(expression, payload=payload, attachment=attachment, **more)

    asker = Asker(Tap(), keys, key)

    def stop() -> str:
        """Why not, if so."""
        try:
            asker.ask_sealed(keys.command, to_record(Command(request=Request.E_STOP)).tobytes(), 2.0, True)
        except TendrilError as error:
            return str(error)
        return ""

    try:
        if why := stop():  # the first question may come before the session is open
            wait(lambda: not stop(), 20.0, f"the E-STOP of a second server: {why}", 0.2)
        with contextlib.suppress(RigHeld):  # the first server commands; the seal was looked at and counted
            asker.ask_sealed(keys.faults, TwinFaults(marker_loss=1.0).model_dump_json().encode())
        asker.leave(1.0)
    finally:
        link.close()
    return found


@contextmanager
def _idle(endpoint: str) -> Iterator[None]:
    host, port = endpoint.partition("/")[2].rsplit(":", 1)
    with ExitStack() as lines:
        for _ in range(IDLE):
            lines.enter_context(socket.create_connection((host, int(port)), 5.0))
        yield
