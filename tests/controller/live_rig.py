"""A real rig process with its client, for tests: commands by name, every row it ever sent, and waiting for a row."""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from controller.link import RigClient
from controller.realtime.ring import Ring, find_ring
from controller.realtime.settings import RigReady, RigSettings
from controller.schema.messages import Command, CommandReply
from controller.schema.modes import Request
from controller.system.keys import read_key

TIMEOUT_S = 200.0
"""A cold cache compiles the whole loop [s]."""


def wait_for(what: Callable[[], Any], patience: float = 20.0) -> Any:
    """The first true answer of `what`."""
    end = time.monotonic() + patience
    while not (found := what()):
        assert time.monotonic() < end, "this never came true"
        time.sleep(0.005)
    return found


class Operator:
    """A client that numbers its commands and collects every row."""

    def __init__(self, endpoint: str, rig: str, key_file: Path) -> None:
        self.batches: list[np.ndarray] = []
        self.boots: list[int] = []
        key, met = read_key(key_file), lambda info: self.boots.append(info.boot)
        self.client = RigClient(endpoint, rig, self.batches.append, met, key=key)
        self.n = 0
        self.request_n = 0

    def send(self, request: Request = Request.NONE, **fields: Any) -> CommandReply:
        """One command; any request is a new one, and every command shows presence unless told otherwise."""
        assert self.client.info
        self.n += 1
        self.request_n += request != Request.NONE
        told = {"boot": self.client.info.boot, "presence": self.n, "request_n": self.request_n} | fields
        reply = self.client.command(Command(n=self.n, request=request, **told))
        if request == Request.E_STOP:  # its number is given by the rig
            self.request_n = reply.n
        return reply

    def arm_and_follow(self) -> None:
        """VENTED -> HOLD -> FOLLOW, towards the straight actuator's tip."""
        assert self.send(Request.ARM).accepted
        assert self.send(Request.FOLLOW, target=(0.24, 0.02)).accepted

    def rows(self) -> np.ndarray:
        """Every row so far, one at least."""
        wait_for(lambda: self.batches)
        return np.concatenate(list(self.batches))

    def newest(self) -> np.void:
        """The newest row; waits for the first: a rig is met before its next batch comes."""
        wait_for(lambda: self.batches)
        return self.batches[-1][-1]  # type: ignore[no-any-return]

    def first(self, column: str, value: int) -> int:
        """Index in `rows()` of the first row with this value, once it is there."""
        wait_for(lambda: np.any(self.rows()[column] == value))
        return int(np.argmax(self.rows()[column] == value))


@dataclass
class LiveRig:
    """A running rig, the process that was started for it, and its operator."""

    settings: RigSettings
    process: subprocess.Popen[bytes]
    ready: RigReady
    operator: Operator

    def ring(self) -> Ring:
        return find_ring(self.settings.rig, self.settings.folder)


@contextmanager
def live_rig(folder: Path, command: list[str] | None = None, **fields: Any) -> Iterator[LiveRig]:
    """A rig with its ring in `folder`; whatever is left of it is killed at the end. One after another may have it."""
    key_file = folder / "test.key"
    settings = RigSettings(rig="test", folder=folder, ready=folder / "ready.json", key_file=key_file, **fields)
    (folder / "ready.json").unlink(missing_ok=True)  # of an earlier one
    command = [sys.executable, *(command or ["-m", "controller.realtime"]), settings.model_dump_json()]
    with subprocess.Popen(command) as process, ExitStack() as cleanup:
        cleanup.callback(process.kill)
        wait_for(lambda: (folder / "ready.json").exists() or process.poll() is not None, TIMEOUT_S)
        assert process.poll() is None
        ready = RigReady.model_validate_json((folder / "ready.json").read_bytes())
        operator = Operator(ready.endpoint, settings.rig, key_file)
        cleanup.callback(operator.client.close)
        wait_for(lambda: operator.client.connected)
        yield LiveRig(settings, process, ready, operator)
