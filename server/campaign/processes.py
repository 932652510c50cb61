"""Processes that die or stand still: server, rig, and the recorder, which is a thread of the server."""

import os
import signal
import time
from concurrent.futures import ThreadPoolExecutor

from controller.schema.modes import Cause, Mode
from server.campaign import trace
from server.campaign.scene import CIRCLE, Scene
from server.campaign.table import RESTART_MS
from server.campaign.waiting import Seen, require, wait
from server.rig import planner

PAUSE = 2.0
"""For which a process is stopped [s]."""
SHORT_PAUSE_S = 0.25
"""The same, longer than the loop's gap and shorter than the supervisor waits [s]."""
LAPS = 20
"""Of a preview that takes longer than that."""
SLACK = 2.0
"""After which a reaction is not waited for any more [s]; its limit is judged by the ring's own times."""
REST_AFTER = 30.0


def held(scene: Scene, start: int) -> tuple[str, float]:
    """The first HOLD after `start` in words, and how long it took [ms]."""
    row = scene.until(start, (Mode.HOLD,), SLACK)
    return trace.told(row), (row["t_ns"] - start) * 1e-6


def server_killed(scene: Scene) -> Seen:
    """The keeper starts the next one at once."""
    scene.track()
    start = time.monotonic_ns()
    os.kill(scene.server_process, signal.SIGKILL)
    observed, took = held(scene, start)
    scene.operator.reconnect()
    require(scene.mode == Mode.HOLD, f"in {scene.mode.name} when the next server was there")
    scene.stays_calm()
    scene.acts_again()
    return Seen(f"{observed}; the next server's page shows HOLD, and an operator can arm again", took)


def planner_killed(scene: Scene) -> Seen:
    """The server has another one at once, and asks it again."""
    scene.track()
    start = time.monotonic_ns()
    killed = scene.work_process(planner.NAME)
    with ThreadPoolExecutor(1) as pool:
        answer = pool.submit(scene.operator.request, "POST", "/api/preview", reference=CIRCLE, laps=LAPS)
        time.sleep(SHORT_PAUSE_S)
        require(not answer.done(), "the preview was there before the planner was killed")
        os.kill(killed, signal.SIGKILL)
        found = answer.result()
    require(found.status_code == 200, f"the preview was answered with {found.status_code}: {found.text[:200]}")
    rows = scene.since(start)
    require((rows["mode"] == Mode.TRACK).all(), f"left TRACK for {Mode(rows['mode'][-1]).name}")
    require(scene.work_process(planner.NAME) != killed, "the planner lives")
    scene.acts_again()
    return Seen(
        f"TRACK; the preview came after {1e-9 * (time.monotonic_ns() - start):.1f} s", trace.longest_gap_ms(rows)
    )


def server_stopped(scene: Scene) -> Seen:
    """What the operator's page said meanwhile waits in the server's sockets."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    os.kill(scene.server_process, signal.SIGSTOP)
    time.sleep(PAUSE)
    os.kill(scene.server_process, signal.SIGCONT)
    observed, took = held(scene, start)
    scene.stays_calm()
    scene.operator.sees("rig: HOLD", mark)
    scene.acts_again()
    return Seen(f"{observed}, still after SIGCONT", took)


def server_gone(scene: Scene) -> Seen:
    """No one starts another one until the rig has vented."""
    scene.track()
    scene.keep_server = False
    start = time.monotonic_ns()
    os.kill(scene.server_process, signal.SIGKILL)
    observed, first = held(scene, start)
    row = scene.until(start + int(1e9 * (REST_AFTER - 1.0)), (Mode.REST, Mode.VENTED), REST_AFTER + SLACK)
    wait(lambda: scene.mode == Mode.VENTED, 20.0, f"VENTED; the rig is in {scene.mode.name}")
    scene.stays_calm()
    scene.keep_server = True
    scene.operator.reconnect()
    scene.acts_again()
    require(first < 1e3, f"HOLD only after {first:.0f} ms")
    return Seen(f"{observed} after {first:.0f} ms, {trace.told(row)}, VENTED", (row["t_ns"] - start) * 1e-6)


def restarted(scene: Scene, start: int, mark: int) -> Seen:
    """Wait for the next boot of the rig, which has to begin vented, and for what the page says."""
    old = scene.boot
    wait(
        lambda: scene.boot not in (0, old) and len(scene.since(start)),
        RESTART_MS / 1e3 + SLACK,
        "a rig that ticks again",
    )
    rows = scene.since(start)
    require((rows["mode"] == Mode.VENTED).all(), "the next boot did not begin vented")
    line = scene.operator.sees("the rig restarted", mark, 20.0)
    scene.stays_calm()
    require(scene.mode == Mode.VENTED, f"in {scene.mode.name} though no one armed")
    scene.acts_again()
    return Seen(f"restarted, {trace.told(rows[0])}; page: {line}", (rows["t_ns"][0] - start) * 1e-6)


def rig_killed(scene: Scene) -> Seen:
    """The twin dies with it."""
    return _lost(scene, signal.SIGKILL)


def rig_stopped(scene: Scene) -> Seen:
    """The supervisor kills a rig whose loop stands still for 0.5 s."""
    return _lost(scene, signal.SIGSTOP)


def rig_killed_stopped(scene: Scene) -> Seen:
    """Only a CLEAR ends what a person stopped, whichever process dies."""
    scene.track()
    stopped = scene.operator.request("POST", "/api/command", request="e_stop")
    require(stopped.is_success, f"the E-STOP was answered with {stopped.status_code}: {stopped.text[:200]}")
    old, mark, start = scene.boot, len(scene.operator.log), time.monotonic_ns()
    os.kill(scene.rig_process, signal.SIGKILL)
    wait(
        lambda: scene.boot not in (0, old) and len(scene.since(start)),
        RESTART_MS / 1e3 + SLACK,
        "a rig that ticks again",
    )
    rows = scene.since(start)
    latched = (rows["mode"] == Mode.E_STOP) & (rows["cause"] == Cause.OPERATOR)
    require(latched.all(), f"the next boot began as {trace.told(rows[0])}, not in E-STOP (operator)")
    line = scene.operator.sees("still in E-STOP (by ", mark, 20.0)
    armed = scene.operator.request("POST", "/api/command", request="arm")
    require(armed.status_code == 409, f"ARM was answered with {armed.status_code}, not refused")
    cleared = scene.operator.request("POST", "/api/command", request="clear")
    require(cleared.is_success, f"CLEAR was answered with {cleared.status_code}: {cleared.text[:200]}")
    scene.acts_again()
    return Seen(f"restarted in E-STOP; page: {line}; CLEAR ends it", (rows["t_ns"][0] - start) * 1e-6)


def _lost(scene: Scene, number: signal.Signals) -> Seen:
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    os.kill(scene.rig_process, number)
    return restarted(scene, start, mark)


def rig_paused(scene: Scene) -> Seen:
    """Too short for the supervisor, too long for the loop."""
    scene.track()
    mark = len(scene.operator.log)
    os.kill(scene.rig_process, signal.SIGSTOP)
    time.sleep(SHORT_PAUSE_S)
    start = time.monotonic_ns()
    os.kill(scene.rig_process, signal.SIGCONT)
    row = scene.until(start, (Mode.HOLD,), SLACK)
    require(row["cause"] == Cause.LOOP_STALLED, f"{trace.told(row)} instead of HOLD (loop stalled)")
    scene.stays_calm()
    line = scene.operator.sees("loop stalled", mark)
    scene.acts_again()
    return Seen(f"{trace.told(row)}; page: {line}", (row["t_ns"] - start) * 1e-6)
