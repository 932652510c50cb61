"""Where a fault happens: rig and server as `tendril up` runs them, and an operator who tracks a circle."""

import contextlib
import itertools
import json
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np

from controller.arrays import Rows
from controller.errors import RigUnreachable
from controller.realtime.ring import find_ring, remove_rings
from controller.realtime.settings import RigSettings
from controller.realtime.supervisor import Supervisor
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import RigParameters, SafetyLimits
from controller.schema.rig_file import parse_rig_file
from controller.system.thread import SupervisedThread
from controller.virtual.firmware import compiler
from controller.virtual.process import VirtualProcess
from server.app.up import ServerChild
from server.campaign import inside, trace
from server.campaign.person import Person
from server.campaign.proxy import Proxy
from server.campaign.table import BOARD_GAP, GAP
from server.campaign.waiting import Failed, Skipped, before_the_fault, require, wait
from server.hardware.actuator import kept_file
from server.hardware.restarts import Restarts
from server.recorder import client
from server.settings import ServerSettings

DAYS = "2"
NAMES = "subjectAltName=IP:127.0.0.1,DNS:localhost\n"


def make_certificates(folder: Path) -> None:
    """ca.pem, cert.pem and key.pem in `folder`, which is made; `Skipped` where there is no openssl."""
    if shutil.which("openssl") is None:
        raise Skipped("no openssl here to make certificates with")
    folder.mkdir()
    (folder / "names.txt").write_text(NAMES)
    for command in (
        f"req -x509 -newkey rsa:2048 -nodes -days {DAYS} -subj /CN=tendril -keyout ca.key -out ca.pem",
        "req -newkey rsa:2048 -nodes -subj /CN=rig -keyout key.pem -out cert.csr",
        f"x509 -req -in cert.csr -CA ca.pem -CAkey ca.key -days {DAYS} -out cert.pem -extfile names.txt",
    ):
        subprocess.run(["openssl", *command.split()], cwd=folder, check=True, capture_output=True)


CIRCLE = "circle_1hz"
SPEED, SLOW = 0.1, 0.01
"""Of the reference on the circle, above that of most of its approach, and of one that moves at all [m/s]."""
QUIET_SECONDS = 2.0
"""How long nothing may move after a fault without a fresh action [s]."""
NAP = 0.05
EMPTY_MAX_S = 5.0
"""Longest wait for chambers that were under pressure to let the rig arm [s]."""
DEVICES_READY_S = 10.0
"""Longest wait for devices that were plugged in again [s]."""


_SCENES = itertools.count()
"""A recorder of an earlier turn that hangs must not be taken for this one's: each scene's rig has a name of its own."""


class Kind(NamedTuple):
    """What a scene must have for a fault."""

    proxied: bool = False
    """The link goes through a `Proxy`."""
    encrypted: bool = False
    """It is over TLS."""
    rate_factor: float = 100.0
    """Times the server's own limits of how often it may be asked."""
    wires: str = ""
    """Rig file of a virtual rig whose devices are driven over their wires; "": the twin."""


class Scene:
    """A product of its own: rig name, ports and folders."""

    def __init__(self, folder: Path, kind: Kind) -> None:
        """Raises Skipped where its devices cannot be stood in for here."""
        self.folder, self.kind = folder, kind
        proxied, encrypted, rate_factor = kind.proxied, kind.encrypted, kind.rate_factor
        folder.mkdir()
        self.tls = folder / "tls" if encrypted else None
        if self.tls:
            make_certificates(self.tls)
        self.rig = f"faults-{os.getpid()}-{next(_SCENES)}"
        self._log = (folder / "output.log").open("wb")
        self._order = folder / "order.json"
        os.environ[inside.ORDER] = str(self._order)
        settings = ServerSettings(
            rig=self.rig,
            port=0,
            state=folder / "state",
            recordings=folder / "recordings",
            light_scene=True,
            rate_factor=rate_factor,
            record_faults=False,
            link_tls=self.tls,
        )
        self.key = settings.key
        self.virtual = _virtual(kind.wires, folder, self._log) if kind.wires else None
        parameters = RigParameters(limits=SafetyLimits(loop_gap=GAP, pressures_lost=BOARD_GAP))
        if self.virtual is not None:
            parameters = self.virtual.rig.parameters(folder).model_copy(update={"limits": parameters.limits})
        self._supervisor = Supervisor(
            RigSettings(
                rig=self.rig,
                listen=f"{'tls' if encrypted else 'tcp'}/127.0.0.1:0",
                key_file=settings.key,
                link_tls=self.tls,
                parameters=parameters,
            ),
            program=(inside.__name__, "controller.realtime"),
            output=self._log,
        )
        self._supervisor.start()
        self._supervisor.wait_ready()
        trace.newest(self.rig)  # loads what reads the ring, or compiles it: later that would cost seconds of a fault
        self.proxy = Proxy(int(self.endpoint.rsplit(":", 1)[1])) if proxied else None
        settings = settings.model_copy(update={"endpoint": self.proxy.endpoint if self.proxy else self.endpoint})
        self.restarts = folder / "restarts" / "actuator.json"
        self.restarts.parent.mkdir()
        settings = settings.model_copy(update={"restarts": self.restarts})
        self._carried_out = Restarts(self.restarts, kept_file(settings), self._supervisor)
        self._server = ServerChild(
            settings, folder / "server.json", program=(inside.__name__, "server.app"), output=self._log
        )
        self.keep_server = True
        self.url = self._server.wait_ready().url
        self._keeper = SupervisedThread("keeper", self._keep)
        self._keeper.start()
        self.operator = Person(self.url)

    @property
    def endpoint(self) -> str:
        """Where the rig itself listens."""
        return self._supervisor.endpoint

    @property
    def rig_process(self) -> int:
        """Process id of the rig."""
        return self._supervisor.process

    @property
    def server_process(self) -> int:
        """Process id of the server."""
        return self._server.process

    def work_process(self, name: str) -> int:
        """Process id of the one that works for the server under this name."""
        tasks = Path(f"/proc/{self.server_process}/task")
        children = [pid for task in tasks.iterdir() for pid in (task / "children").read_text().split()]
        lines = {int(pid): Path(f"/proc/{pid}/cmdline").read_text().split("\0") for pid in children}
        return next(pid for pid, line in lines.items() if name in line)

    @property
    def recorder_process(self) -> int:
        """Process id of what records this rig, for whichever server."""
        for entry in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if {client.WRITING, self.rig} <= {*(entry / "cmdline").read_text().split("\0")}:
                    return int(entry.name)
        raise Failed("nothing records")

    @property
    def boot(self) -> int:
        """The rig's boot that writes the newest ring; 0 between two boots."""
        try:
            return find_ring(self.rig).boot
        except RigUnreachable:
            return 0

    @property
    def mode(self) -> Mode:
        """What the rig's ring says."""
        return Mode(trace.newest(self.rig)["mode"])

    def since(self, t_ns: int) -> Rows:
        """The rig's rows from `t_ns` on."""
        return trace.since(self.rig, t_ns)

    def until(self, t_ns: int, modes: tuple[Mode, ...], seconds: float) -> np.void:
        """The first row after `t_ns` in one of `modes`; `Failed` if there is none within `seconds` from now."""
        found: list[np.void] = []

        def look() -> bool:
            rows = self.since(t_ns)
            found[:] = rows[np.isin(rows["mode"], modes)][:1]
            return bool(found)

        try:
            wait(look, seconds, " or ".join(mode.name for mode in modes))
        except Failed as error:
            raise Failed(f"{error}; the rig is in {self.mode.name}") from error
        return found[0]

    def break_inside(self, *processes: int, **order: Any) -> None:
        """Let `processes` do something to themselves; see `inside.act`."""
        self._order.write_text(json.dumps(order))
        for process in processes:
            os.kill(process, signal.SIGUSR1)

    def go_on_inside(self) -> None:
        """Take the order back: what hangs goes on."""
        self._order.unlink()

    def block_supervisor(self) -> Path:
        """Let the system refuse (OSError) to start another rig, until the folder that this gives is removed."""
        place = self._supervisor.settings.ready
        assert place is not None
        place.unlink(missing_ok=True)
        place.mkdir()
        return place

    def wait_for_devices(self) -> None:
        """Until devices, where it has some, are there and run."""
        if self.virtual is not None:
            wait(self._devices_run, DEVICES_READY_S, "devices that run", 0.1)

    def hold(self) -> None:
        """Bring the operator to a rig that holds, from wherever things are."""
        with before_the_fault():
            self.operator.reconnect()
            self.operator.request("POST", "/api/run/stop")
            self._arm_again()

    def track(self) -> None:
        """Bring the operator to tracking a circle, from wherever things are."""
        self.hold()
        with before_the_fault():
            self.operator.ask("POST", "/api/run", reference=CIRCLE, laps=None, record=False)
            self._until_moving(Mode.TRACK, SPEED)

    def drag(self) -> None:
        """Bring the operator to dragging the target."""
        self.hold()
        with before_the_fault():
            self.operator.drag()
            self._until_moving(Mode.FOLLOW, SLOW)

    def stays_calm(self, seconds: float = QUIET_SECONDS) -> None:
        """Require that nothing moves from now on, though the operator may be present."""
        start = time.monotonic_ns()
        time.sleep(seconds)
        require(not (what := trace.calm(self.since(start))), f"moved without a fresh action: {what}")

    def acts_again(self) -> None:
        """Require that a fresh action works: E-STOP, clear, arm, drag."""
        self.operator.dragging = False
        self._arm_again()
        self.operator.drag()
        start = time.monotonic_ns()
        self.until(start, (Mode.FOLLOW,), 5.0)
        self.operator.dragging = False
        self.operator.command("e_stop")

    def close(self) -> None:
        """End everything; nothing is left in shared memory."""
        self._keeper.stop()
        self.operator.close()
        for process in (self.server_process, self.rig_process):
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGCONT)
        if self.proxy:
            self.proxy.mend()
        self._server.stop()
        self._supervisor.stop()
        if self.virtual is not None:
            self.virtual.stop()
        if self.proxy:
            self.proxy.close()
        self._log.close()
        remove_rings(self.rig)
        shutil.rmtree(self.folder, ignore_errors=True)

    def output(self) -> str:
        """What rig and server printed so far."""
        return (self.folder / "output.log").read_text(errors="replace")

    def _keep(self) -> None:
        while not self._keeper.wait(NAP):
            if self.keep_server:
                self._server.keep_alive()
            self._carried_out.look()

    def _arm_again(self) -> None:
        self.wait_for_devices()
        for request in ("e_stop", "clear"):
            self.operator.command(request)
        wait(self._armed, EMPTY_MAX_S, "chambers that are empty, so that it arms", 0.1)
        start = time.monotonic_ns()
        self.until(start, (Mode.HOLD,), 2.0)
        wait(lambda: self.operator.shows(Mode.HOLD, start), 5.0, "HOLD on the page")

    def _armed(self) -> bool:
        return self.operator.request("POST", "/api/command", request="arm").is_success

    def _devices_run(self) -> bool:
        drivers = self.operator.ask("GET", "/api/drivers")["drivers"]
        return all(one["state"] == "running" for one in drivers)

    def _until_moving(self, mode: Mode, speed: float) -> None:
        def moving() -> bool:
            row = trace.newest(self.rig)
            require(row["mode"] in (mode, Mode.HOLD), f"the rig went to {trace.told(row)} before the fault")
            require(row["cause"] != Cause.LOOP_STALLED, "the machine stood still before the fault")
            return bool(row["mode"] == mode and np.hypot(*row["p_ref_dot"]) > speed)

        wait(moving, 15.0, f"motion in {mode.name}")
        time.sleep(0.5)


def _virtual(text: str, folder: Path, output: IO[bytes]) -> VirtualProcess:
    if parse_rig_file(text, "the scene's rig").valves.driver == "serial" and compiler() is None:
        raise Skipped("no C++ compiler for the board's firmware")
    return VirtualProcess(text, folder, output)
