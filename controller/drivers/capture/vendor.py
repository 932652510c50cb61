"""Vicon, Qualisys, VRPN and others through the package motioncapture (libmotioncapture), in a process of its own.

Its Python side gives positions of rigid bodies only: no single markers, no times of capture and no end of waiting, and
it holds up every thread of its process while it connects. So each connection is a process that prints what comes.
"""

import json
import os
import re
import selectors
import subprocess
import sys
import time
from pathlib import Path
from typing import IO, Annotated, Any

import motioncapture
import numpy as np
from pydantic import Field as Bounds
from pydantic import field_validator

from controller.arrays import Array
from controller.drivers.device import COORDINATE_MAX_M, POINTS_MAX, CaptureDevice, DeviceError, Sample, plausible
from controller.errors import spelled
from controller.schema.layout import Model
from controller.system.child import end_now

OPENING = 5.0
"""A connection that is not there after this is given up [s]."""
LINE_MAX_BYTES = 1 << 18
"""No line is longer [bytes]."""
SILENCE = 5.0
"""Without a frame for so long, the connection is made again [s]."""
REPEATS = ("vrpn",)
"""Systems whose back end gives the last poses again and again, whatever became of the cameras."""


class VendorOptions(Model):
    """Which system, and where it is."""

    system: Annotated[str, spelled(r"^[a-z_]{1,40}$", "as vicon, qualisys, vrpn or optitrack")]
    hostname: Annotated[str, spelled(r"^[A-Za-z0-9.:-]{1,253}$", "a host name or address")] = "localhost"
    settings: Annotated[tuple[str, ...], Bounds(max_length=16)] = ()
    """More that the package takes, as "port=22222" or "interface_ip=192.168.1.5"."""

    @field_validator("settings")
    @classmethod
    def _pairs(cls, settings: tuple[str, ...]) -> tuple[str, ...]:
        for text in settings:
            if not re.fullmatch(r"[a-z_A-Z]{1,40}=[^\0]{0,4096}", text):
                raise ValueError(f'{text[:40]} is not of the form "name=value"')
        return settings

    def config(self) -> dict[str, str]:
        """As the package takes it."""
        return {"hostname": self.hostname} | dict(text.split("=", 1) for text in self.settings)


class Vendor(CaptureDevice[VendorOptions]):
    """Rigid bodies of a system for which the installed wheel of motioncapture was built."""

    Options = VendorOptions
    capabilities = ("rigid bodies",)

    def __init__(self, options: VendorOptions) -> None:
        """Touches nothing."""
        super().__init__(options)
        self._process: subprocess.Popen[bytes] | None = None
        self._rest = b""
        self._heard = 0.0
        self._last: Array = np.empty((0, 3))

    @property
    def name(self) -> str:
        """As "vicon at 192.168.1.10"."""
        return f"{self.options.system} at {self.options.hostname}"

    def open(self) -> None:
        """Connect; raises DeviceError where the wheel knows no such system, or nothing answers."""
        self.close()
        o = self.options
        if o.system not in (there := systems()):
            raise DeviceError(f"system = {o.system}: this wheel of motioncapture has {', '.join(there)}")
        script = Path(__file__).with_name("vendor_process.py")
        self._process = subprocess.Popen(
            [sys.executable, os.fspath(script), o.system, json.dumps(o.config())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
        )
        self._rest, self._last = b"", np.empty((0, 3))
        try:
            self._await_ready(time.monotonic() + OPENING)
            self._heard = time.monotonic()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            end_now(process)

    def read(self, timeout: float) -> Sample | None:
        """The next frame within `timeout` [s]; DeviceError once the connection has ended."""
        deadline = time.monotonic() + timeout
        while (line := self._line(deadline)) is not None:
            try:
                sample = _sample(line)
            except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError):
                self.rejected += 1
                continue
            if self.options.system not in REPEATS or not np.array_equal(sample.points, self._last):
                self._last, self._heard = sample.points, time.monotonic()
                return sample
        if time.monotonic() - self._heard > SILENCE:
            raise DeviceError(f"nothing new came from {self.name} for {SILENCE:g} s")
        return None

    def _await_ready(self, deadline: float) -> None:
        """Until the process says that it is connected; the wheel itself may print before."""
        while (line := self._line(deadline)) is not None:
            if line == b"ready":
                return
            if line.startswith(b'{"error"'):
                raise DeviceError(f"{self.name}: {json.loads(line)['error'] or 'no connection'}")
        raise DeviceError(f"{self.name}: no connection within {OPENING:g} s")

    def _line(self, deadline: float) -> bytes | None:
        """The next line before `deadline`; raises DeviceError where there will be none."""
        while b"\n" not in self._rest:
            left = deadline - time.monotonic()
            try:
                if not _readable(self._out, max(0.0, left)):
                    return None
                more = os.read(self._out.fileno(), 65536)
            except ValueError as error:  # another thread closed it
                raise DeviceError(f"{self.name} is not open") from error
            if not more or len(self._rest) > LINE_MAX_BYTES:
                raise DeviceError(f"{self.name}: the connection ended")
            self._rest += more
        line, _, self._rest = self._rest.partition(b"\n")
        return line

    @property
    def _out(self) -> IO[bytes]:
        if self._process is None or self._process.stdout is None:
            raise DeviceError(f"{self.name} is not open")
        return self._process.stdout


def systems() -> list[str]:
    """What the installed wheel of motioncapture was built for, by the names of its classes."""
    code = Path(str(motioncapture.__file__)).read_bytes()
    found = {match.decode().lower() for match in re.findall(rb"libmotioncapture\d+MotionCapture(\w+?)E\0", code)}
    known = {"optitrackclosedsource": "optitrack_closed_source"}
    return sorted(known.get(name, name) for name in found if name.isalpha())


def _readable(pipe: IO[bytes], timeout: float) -> bool:
    with selectors.PollSelector() as selector:  # epoll would wait on for a pipe that another thread has closed
        selector.register(pipe, selectors.EVENT_READ)
        return bool(selector.select(timeout))


def _sample(line: bytes) -> Sample:
    """Raises ValueError and what else comes of a line that is no frame."""
    told: Any = json.loads(line)
    bodies = told["bodies"]
    if len(bodies) > POINTS_MAX:
        raise ValueError(f"{len(bodies)} bodies, more than {POINTS_MAX}")
    points = np.array(list(bodies.values()), float).reshape(-1, 3)
    if not plausible(points):
        raise ValueError(f"a coordinate is beyond {COORDINATE_MAX_M:g} m")
    return Sample(int(told["t"]), points, tuple(map(str, bodies)))
