"""What fails, hangs or ends inside the server or its supervisor while everything around it works."""

import os
import signal
import time

from controller.schema.modes import Mode
from server.access.tokens import TokenFile
from server.campaign import trace
from server.campaign.processes import held, restarted
from server.campaign.rows.files import recording
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require, wait
from server.settings import ServerSettings

FAILING = 3.0
"""How long a job of the event loop fails [s]."""
HANGING = 8.0
"""How long the disk takes nothing [s]."""
STANDING, STOPPED_IN, DEAD = 2.0, 5.0, 30.0
"""How long the event loop stands still [s]: it is waited for, E-STOP is pressed meanwhile, or it is not waited for."""
BLOCKED = 2.0
"""How long the system refuses another rig [s]."""


def _stops(scene: Scene) -> float:
    """How long an E-STOP takes [ms], from the press to the ring."""
    start = time.monotonic_ns()
    scene.operator.command("e_stop")
    row = scene.until(start, (Mode.E_STOP,), 2.0)
    return float(row["t_ns"] - start) * 1e-6


def beat_failing(scene: Scene) -> Seen:
    """One job of the event loop raises each time."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    calls = ["server.health.alarms:AlarmWatch._figures"]  # `judge` itself is held by the scheduler
    scene.break_inside(scene.server_process, calls=calls, how="fail", seconds=FAILING)
    line = scene.operator.sees("the alarms fails: OSError", mark, FAILING)
    took = (time.monotonic_ns() - start) * 1e-6
    frame = scene.operator.frame
    wait(lambda: scene.operator.frame is not frame, 1.0, "frames while the job fails")
    rows = scene.since(start)
    require((rows["mode"] == Mode.TRACK).all(), f"the rig did not go on: {trace.told(rows[-1])}")
    stop = _stops(scene)
    scene.acts_again()
    return Seen(f"TRACK, frames; page: {line}; E-STOP in {stop:.0f} ms", took)


def disk_hung(scene: Scene) -> Seen:
    """Neither the recording's disk nor that of the logs takes anything, and none of them fails either."""
    scene.track()
    id = recording(scene)
    mark, start = len(scene.operator.log), time.monotonic_ns()
    calls = ["recordings.write.session:Session.write", "server.log.event_file:EventFile.append"]
    scene.break_inside(scene.server_process, scene.recorder_process, calls=calls, how="hang", seconds=HANGING)
    line = scene.operator.sees("the disk took nothing", mark, HANGING)
    took = (time.monotonic_ns() - start) * 1e-6
    rows = scene.since(start)
    require((rows["mode"] == Mode.TRACK).all(), f"the rig did not go on: {trace.told(rows[-1])}")
    stop = _stops(scene)
    require(time.monotonic_ns() - start < 1e9 * HANGING, "the disk was back before the E-STOP")
    scene.operator.sees("has caught up", mark, 30.0)
    scene.acts_again()
    done = scene.operator.ask("DELETE", "/api/recordings/current")
    require(
        done["id"] == id and done["complete"] and not done["gaps"], f"{done['id']}: {done['gaps']} ticks are missing"
    )
    return Seen(f"TRACK; page: {line}; E-STOP in {stop:.0f} ms; {done['rows']} rows, none missing", took)


def loop_stuck(scene: Scene) -> Seen:
    """No one is heard meanwhile; the operator's thread goes on repeating."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    scene.break_inside(scene.server_process, stand=STANDING)
    observed, took = held(scene, start)
    line = scene.operator.sees("the event loop stood still", mark)
    scene.stays_calm()
    scene.acts_again()
    return Seen(f"{observed}; page: {line}", took)


def loop_stuck_stop(scene: Scene) -> Seen:
    """The network and the E-STOP's thread need nothing of that loop."""
    scene.track()
    start = time.monotonic()
    scene.break_inside(scene.server_process, stand=STOPPED_IN)
    time.sleep(0.2)
    took = _stops(scene)
    require(time.monotonic() - start < STOPPED_IN, "the answer came when the loop went on")
    scene.stays_calm()
    scene.acts_again()
    return Seen("E-STOP, answered", took)


def loop_dead(scene: Scene) -> Seen:
    """It never comes back, so its process is ended, and the keeper starts another one."""
    scene.track()
    process, start = scene.server_process, time.monotonic_ns()
    scene.break_inside(process, stand=DEAD)
    observed, _ = held(scene, start)
    wait(lambda: scene.server_process != process, DEAD, "another server")
    took = (time.monotonic_ns() - start) * 1e-6
    scene.operator.reconnect()
    scene.stays_calm()
    scene.acts_again()
    return Seen(f"{observed}; another server after {1e-3 * took:.1f} s, and an operator can arm again", took)


def thread_dead(scene: Scene) -> Seen:
    """The thread that commands the rig ends."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    calls = ["server.operate.operator:Operator._serve"]
    scene.break_inside(scene.server_process, calls=calls, how="end", seconds=1.0)
    line = scene.operator.sees("the thread operator was ended by SystemExit", mark)
    took = (time.monotonic_ns() - start) * 1e-6
    modes = [Mode(mode) for mode in dict.fromkeys(scene.since(start)["mode"].tolist())]
    require(modes in ([Mode.TRACK], [Mode.TRACK, Mode.HOLD]), f"went through {', '.join(mode.name for mode in modes)}")
    stop = _stops(scene)
    scene.acts_again()
    return Seen(f"{' then '.join(mode.name for mode in modes)}; page: {line}; E-STOP in {stop:.0f} ms", took)


def supervisor_oserror(scene: Scene) -> Seen:
    """The rig dies, and the system does not let the supervisor start another one."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    place = scene.block_supervisor()
    os.kill(scene.rig_process, signal.SIGKILL)
    time.sleep(BLOCKED)
    place.rmdir()
    seen = restarted(scene, start, mark)
    return Seen(f"tried again for {BLOCKED:g} s; {seen.observed}", seen.reaction_ms)


def token_unreadable(scene: Scene) -> Seen:
    """The operator's token is revoked, but the first looks at the file are refused."""
    scene.track()
    path = scene.folder / "state" / "secrets.json"
    file, before = TokenFile(ServerSettings(state=scene.folder / "state")), path.read_bytes()
    mark = len(scene.operator.log)
    token = file.renew("operator")
    path.chmod(0o644)  # which is refused, as others could read it; its time of change stays
    scene.operator.sees("the access tokens stay as they were", mark)
    start = time.monotonic_ns()
    path.chmod(0o600)
    observed, took = held(scene, start)
    answer = scene.operator.request("POST", "/api/lease")
    require(answer.status_code == 401, f"the revoked token still operates: {answer.status_code}")
    _sign_in(scene, token)
    scene.stays_calm()
    path.write_bytes(before)
    wait(lambda: scene.operator.request("GET", "/api/session").status_code == 401, 5.0, "the end of the new token")
    _sign_in(scene, scene.url.split("token=")[1])
    scene.acts_again()
    return Seen(f"{observed}; the revoked session ended, a new one operates", took)


def _sign_in(scene: Scene, token: str) -> None:
    scene.operator.ask("POST", "/api/session", token=token)
    scene.operator.reconnect()
