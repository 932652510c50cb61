"""The rig process: the loop in its own thread, and in the main thread the pump from the ring to the link.

Whatever ends the main thread also ends the loop: SIGTERM, SIGINT, an exception, or the loss of its parent.
"""

import logging
import os
import resource
import secrets
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from controller.assembly.controllers.registry import controllers
from controller.assembly.rig import build_rig
from controller.drivers.driver import Driver
from controller.drivers.hardware import HardwareDriver
from controller.drivers.twin import TwinDriver
from controller.errors import TendrilError
from controller.link.keys import open_session
from controller.link.rig_end import RigEnd
from controller.link.seal import Seals
from controller.link.version import LAYOUT, OURS
from controller.realtime.command_handler import CommandHandler
from controller.realtime.latch import Latch, latch_path
from controller.realtime.loop import LoopMemory, compile_loop, loop_memory, run_baseline, run_loop
from controller.realtime.mailbox import post, receive, words
from controller.realtime.only_one import only_one
from controller.realtime.pause import Pause
from controller.realtime.priority import pin_memory, prefer_process, raise_thread_priority
from controller.realtime.ring import PUMP_NS, STOP, Ring, create_ring
from controller.realtime.settings import RigReady, failure_file, free_port
from controller.realtime.settings import RigSettings as RigSettings
from controller.schema.layout import record_dtype
from controller.schema.messages import RigInfo, Telemetry, ValveCommand
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import RigParameters
from controller.simulation.controller_trial import strangers, unfit
from controller.system.keys import key_path, made_key
from controller.system.logs import flush_log, log_in_background
from controller.system.origin import commit
from controller.system.whole_file import write_whole

log = logging.getLogger(__name__)

PUMP_S = 1 / 60
AGAIN = "TENDRIL_RIG_AGAIN"
"""In the environment of a rig that began again after it had to compile."""
NO_ROWS = np.empty(0, record_dtype(Telemetry))
"""Sent while the twin is paused: the rig is there, and nothing new."""
BATCH_ROWS_MAX = 1000
"""In one batch: a pump that was held up for long sends several."""


def run_rig(settings: RigSettings) -> None:
    """Run a rig in this process, from its main thread, until SIGTERM or SIGINT."""
    prefer_process()
    log_in_background()
    _allow_connections()
    with _failure_told(settings.ready), only_one(settings):
        load_kernels(settings.parameters)
        RigProcess(settings).run()


class RigProcess:
    """Builds everything in the constructor, so that arming is possible only when no step is slow."""

    def __init__(self, settings: RigSettings) -> None:
        self.settings = settings
        self.boot = secrets.randbits(62) + 1
        key_file = settings.key_file or key_path(settings.rig)
        self._key = made_key(key_file)
        self._seals = Seals(self._key, self.boot, str(key_file))
        self.policy = "none"
        parameters = settings.parameters
        self._period_ns = round(parameters.controller.dt * 1e9)
        self._refused = {name: unfit(parameters, name) for name in strangers()}
        self._rig = build_rig(parameters, self.boot)
        self._driver = rig_driver(parameters)
        self._latch = Latch(latch_path(key_file, settings.rig))
        self._begin_latched()
        self.ring: Ring = create_ring(settings.rig, self.boot, settings.folder)
        plant = self._driver.plant
        self.memory: LoopMemory = loop_memory(self.ring.header, self.ring.rows, self._rig, plant)
        self._outlet = np.zeros(1, record_dtype(ValveCommand))
        self._outlet_scratch = words(self._outlet).copy()
        self._sent = 0

    def _begin_latched(self) -> None:
        """Begin in the state in which an earlier process was, if only a CLEAR leads out of it."""
        kept = self._latch.kept
        if kept is not None:
            state = self._rig.control.state[0]
            state["mode"], state["cause"] = kept.mode, kept.cause
            by = f"by {kept.by}" if kept.by else kept.cause.name
            fields = {"rig": self.settings.rig, "mode": kept.mode.name, "by": by, "since": kept.at.isoformat()}
            log.warning("rig %s begins latched: %s (%s) since %s; CLEAR ends it", *fields.values(), extra=fields)

    def run(self) -> None:
        """Start loop and link, pump until the stop, then leave a last row that drives nothing, sent and in the ring.

        The ring's file goes after an orderly end; whoever has it open reads on. What fails leaves it for who asks why.
        """
        endpoint = free_port(self.settings.listen)
        session = open_session(key=self._key, listen=endpoint, tls=self.settings.link_tls)
        threads = [threading.Thread(target=self._loop, name="loop")]
        if self.settings.baseline:
            threads.append(threading.Thread(target=self._baseline, name="baseline"))
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: self.stop(Cause.OPERATOR))
        pin_memory()
        self._beat()
        try:
            self._driver.start(self._post, self.ring.newest, self._valve_command)
            for thread in threads:
                thread.start()
            self._wait_first_tick(threads[0])
            handler = self._handler()
            end = RigEnd(session, self.settings.rig, self._seals, handler)
            self._say_ready(endpoint)
            self._pump(threads[0], end, handler.pause)
        finally:
            self.stop(Cause.PUMP_LOST)
            for thread in threads:
                thread.join()
            self._driver.stop()
            self._latch.look(self.ring.newest())
            self._latch.close()
            session.close()
        self.ring.path.unlink(missing_ok=True)

    def stop(self, cause: Cause) -> None:
        """Let the loop end after its current tick; the first cause stays."""
        if self.ring.header[STOP] == 0:
            self.ring.header[STOP] = cause

    def _loop(self) -> None:
        self.policy = raise_thread_priority()
        run_loop(self._rig, self._driver.plant, self.memory, self._period_ns)

    def _post(self, record: np.ndarray) -> None:
        post(self.memory.measurements, words(record))

    def _valve_command(self) -> np.void:
        """The newest command of the loop; the one before where it is just being written."""
        receive(self.memory.outlets, 0, self._outlet_scratch, words(self._outlet))
        newest: np.void = self._outlet[0]
        return newest

    def _wait_first_tick(self, loop: threading.Thread) -> None:
        while self.ring.head == 0 and loop.is_alive():
            self._beat()
            time.sleep(1e-3)

    def _baseline(self) -> None:
        raise_thread_priority()
        run_baseline(self.ring.header, self._period_ns)

    def _pump(self, loop: threading.Thread, end: RigEnd, pause: Pause) -> None:
        due = time.monotonic()
        while loop.is_alive():
            self._beat()
            self._latch.look(self.ring.newest())
            self._send(end)
            pause.look()
            if pause.rests and self.ring.head == self._sent:
                end.publish(NO_ROWS)
            self._leave_orphaned()
            due = max(due + PUMP_S, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
        self._send(end, last=True)
        end.close()
        if self.ring.header[STOP] == 0:
            raise TendrilError("the control loop ended by itself")

    def _beat(self) -> None:
        self.ring.header[PUMP_NS] = time.monotonic_ns()

    def _send(self, end: RigEnd, last: bool = False) -> None:
        """All that is there now; what comes meanwhile waits for its own turn."""
        publish = end.publish_last if last else end.publish
        for _ in range(1 + (self.ring.head - self._sent) // BATCH_ROWS_MAX):
            start, rows = self.ring.read(self._sent, BATCH_ROWS_MAX)
            if len(rows):
                publish(rows)
            self._sent = start + len(rows)

    def _leave_orphaned(self) -> None:
        """Without the parent no one would ever end this process: stay until the safety states brought it to rest."""
        if self.settings.parent not in (0, os.getppid()) and at_rest(self.ring.newest()):
            self.stop(Cause.SERVER_LOST)

    def _handler(self) -> CommandHandler:
        info = RigInfo(
            rig=self.settings.rig,
            boot=self.boot,
            version=OURS,
            commit=commit(),
            layout=LAYOUT,
            wall_offset_ns=time.time_ns() - time.monotonic_ns(),
            policy=self.policy,
            twin=self._driver.simulated,
            parameters=self.settings.parameters,
            observer_gains_max=tuple(self._rig.observer.gain_max.tolist()),
            controllers=tuple(one.info(self._refused.get(one.name, "")) for one in controllers()),
        )
        return CommandHandler(info, self.ring, self.memory.commands, self._rig.control, self._driver, self._latch)

    def _say_ready(self, endpoint: str) -> None:
        fields = {"rig": self.settings.rig, "endpoint": endpoint, "policy": self.policy}
        log.info("rig %s ready on %s, %s", *fields.values(), extra=fields)
        if self.settings.ready:
            ready = RigReady(endpoint=endpoint, boot=self.boot, process=os.getpid())
            write_whole(self.settings.ready, ready.model_dump_json(), lasting=False)


def at_rest(row: np.void | None) -> bool:
    """Whether nothing is driven after the tick of `row`, and nothing will be unless someone asks for it."""
    if row is None or row["mode"] in (Mode.VENTED, Mode.E_STOP):
        return True
    return bool(row["mode"] == Mode.FAULT and not row["u"].any())


def rig_driver(parameters: RigParameters) -> Driver:
    """The twin, or the real devices that `parameters` name; raises ParameterError where it cannot be built."""
    if parameters.hardware is None:
        return TwinDriver(parameters)
    return HardwareDriver(parameters, parameters.hardware)


def load_kernels(parameters: RigParameters) -> None:
    """Have all that the loop calls in this process, from the cache: who compiles keeps 370 MB of it, who loads none.

    So a process that had to compile, after an update or on another kind of processor, begins again in its own place.
    Once: where the cache keeps nothing it would compile again.
    """
    if compile_loop(build_rig(parameters, boot=1), rig_driver(parameters).plant) and AGAIN not in os.environ:
        flush_log()
        os.execve(sys.executable, sys.orig_argv, os.environ | {AGAIN: "1"})


def _allow_connections() -> None:
    """As many open files as may be: connections of strangers that say nothing must not use them up."""
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


@contextmanager
def _failure_told(ready: Path | None) -> Iterator[None]:
    """Leave the reason for the process that waits for `ready`."""
    try:
        yield
    except Exception as error:
        text = str(error) if isinstance(error, TendrilError) else f"{type(error).__name__}: {error}"
        if ready is not None:
            with suppress(OSError):
                write_whole(failure_file(ready), text, lasting=False)
        raise
