"""A way through this machine between a driver and its device: over TCP and UDP, or a serial line."""

import os
import pty
import select
import selectors
import shutil
import socket
import tempfile
import tty
import weakref
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

from controller.errors import ParameterError
from controller.system.thread import SupervisedThread

LOOPBACK = "127.0.0.1"
THREAD = "conformance-relay"
HOSTS = ("host", "hostname", "server", "address", "ip")
"""Options that name a machine, beside a number called "port"."""
PATHS = ("port", "device", "path", "tty")
"""Options that name a serial line."""
BAUDS = ("baud", "baudrate")
BAUD_USUAL = 115200
AT_ONCE = 65536
"""Bytes that are read in one go at most."""
LOOK_S, CLOSED_S = 0.05, 0.005
"""Longest wait before a relay looks whether it is to end; pause while a driver has its serial line closed [s]."""
STUCK_S = 1.0
"""Longest that a connection, or what is written to it, may wait [s]."""

Passes = Callable[[bytes, bool], bool]
"""Whether these bytes go on; True beside those that leave for the device."""


class Relay(Protocol):
    """Carries bytes both ways from `start` to `stop`, as often as one likes."""

    @property
    def options(self) -> dict[str, str | int]:
        """By which the driver takes this way."""

    def start(self) -> None:
        """Begin; raises OSError."""

    def stop(self) -> None:
        """Drop every connection."""


def relay_for(options: dict[str, Any], passes: Passes) -> Relay:
    """To the device that `options` of a driver name; ParameterError where they name no host and port, and no line."""
    host = next((name for name in HOSTS if isinstance(options.get(name), str)), "")
    if host and isinstance(options.get("port"), int):
        return NetworkRelay(host, (options[host], options["port"]), passes)
    path = next((name for name in PATHS if str(options.get(name, "")).startswith("/")), "")
    if path:
        baud = next((options[name] for name in BAUDS if name in options), BAUD_USUAL)
        return SerialRelay(path, (options[path], baud), passes)
    raise ParameterError(
        f"options {', '.join(options) or 'that there are none of'}: none of {', '.join(HOSTS)} with a port, and no "
        f"{', '.join(PATHS)} that is a path, so that there is no way that could be recorded"
    )


class NetworkRelay:
    """One port of this machine for TCP and UDP alike."""

    def __init__(self, name: str, device: tuple[str, int], passes: Passes) -> None:
        """`name`: the option for the host."""
        self._name, self._device, self._passes = name, device, passes
        self._port = 0
        self._thread: SupervisedThread | None = None
        self._others: dict[socket.socket, socket.socket] = {}
        """The other end of each TCP connection."""
        self._ways: dict[Any, socket.socket] = {}
        """To the device, for each sender of datagrams."""

    @property
    def options(self) -> dict[str, str | int]:
        """By which the driver takes this way; known once it was started."""
        return {self._name: LOOPBACK, "port": self._port}

    def start(self) -> None:
        """Listen; raises OSError."""
        if self._thread is not None:
            return
        self._listener = socket.create_server((LOOPBACK, self._port))
        self._port = self._listener.getsockname()[1]
        self._datagrams = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._datagrams.bind((LOOPBACK, self._port))
        except OSError:
            self._listener.close()
            self._datagrams.close()
            raise
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ, self._accept)
        self._selector.register(self._datagrams, selectors.EVENT_READ, self._datagram)
        self._thread = SupervisedThread(THREAD, self._run)
        self._thread.start()

    def stop(self) -> None:
        """Drop every connection."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        thread.stop()
        for key in list(self._selector.get_map().values()):
            key.fileobj.close()  # type: ignore[union-attr]  # sockets, all of them
        self._selector.close()
        self._others.clear()
        self._ways.clear()

    def _run(self) -> None:
        thread = self._thread
        while thread is not None and not thread.stopping:
            thread.turn()
            for key, _ in self._selector.select(LOOK_S):
                key.data()

    def _accept(self) -> None:
        with suppress(OSError):
            near = self._listener.accept()[0]
            try:
                far = socket.create_connection(self._device, STUCK_S)
            except OSError:
                near.close()
                return
            for here, there, leaves in ((near, far, True), (far, near, False)):
                here.settimeout(STUCK_S)
                here.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._others[here] = there
                self._selector.register(here, selectors.EVENT_READ, lambda a=here, b=leaves: self._pump(a, b))

    def _pump(self, source: socket.socket, leaves: bool) -> None:
        target = self._others.get(source)
        if target is None:  # the other end was dropped just now
            return
        try:
            data = source.recv(AT_ONCE)
            if data and self._passes(data, leaves):
                target.sendall(data)
        except OSError:
            data = b""
        if not data:
            for one in (source, target):
                self._others.pop(one)
                self._selector.unregister(one)
                one.close()

    def _datagram(self) -> None:
        with suppress(OSError):
            data, sender = self._datagrams.recvfrom(AT_ONCE)
            if self._passes(data, True):
                self._way(sender).send(data)

    def _way(self, sender: Any) -> socket.socket:
        if sender not in self._ways:
            family, kind, _, _, address = socket.getaddrinfo(*self._device, type=socket.SOCK_DGRAM)[0]
            way = socket.socket(family, kind)
            way.connect(address)
            self._ways[sender] = way
            self._selector.register(way, selectors.EVENT_READ, lambda: self._answer(way, sender))
        return self._ways[sender]

    def _answer(self, way: socket.socket, sender: Any) -> None:
        with suppress(OSError):
            data = way.recv(AT_ONCE)
            if self._passes(data, False):
                self._datagrams.sendto(data, sender)


class SerialRelay:
    """A pseudo-terminal; the real line is open while the driver has this one open, so that a board restarts as ever."""

    def __init__(self, name: str, device: tuple[str, int], passes: Passes) -> None:
        """`name`: the option for the path; `device`: path and baud."""
        self._name, self._device, self._passes = name, device, passes
        self._folder = Path(tempfile.mkdtemp(prefix="tendril-relay-"))
        self._forgotten = weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        self._thread: SupervisedThread | None = None
        self._real: Any = None

    @property
    def options(self) -> dict[str, str | int]:
        """By which the driver takes this way."""
        return {self._name: str(self._folder / "tty")}

    def start(self) -> None:
        """Make the terminal; raises OSError."""
        if self._thread is not None:
            return
        self._end, driver_end = pty.openpty()
        tty.setraw(driver_end)
        (self._folder / "tty").symlink_to(os.ttyname(driver_end))
        os.close(driver_end)  # from now on it is hung up until the driver opens it
        self._thread = SupervisedThread(THREAD, self._run)
        self._thread.start()

    def stop(self) -> None:
        """Take the terminal away."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        thread.stop()
        self._shut()
        (self._folder / "tty").unlink(missing_ok=True)
        os.close(self._end)

    def _run(self) -> None:
        thread = self._thread
        looks = select.poll()
        looks.register(self._end, select.POLLIN)
        while thread is not None and not thread.stopping:
            thread.turn()
            if any(event == select.POLLHUP for _, event in looks.poll(0)):
                self._shut()
                thread.wait(CLOSED_S)
            else:
                self._carry()

    def _carry(self) -> None:
        try:
            real = self._opened()
            ready = select.select([self._end, real.fileno()], [], [], LOOK_S)[0]
            if self._end in ready:
                data = os.read(self._end, AT_ONCE)
                if self._passes(data, True):
                    real.write(data)
            if real.fileno() in ready:
                data = real.read(AT_ONCE)
                if self._passes(data, False):
                    os.write(self._end, data)
        except OSError:  # one of the two is gone, and is looked for again
            self._shut()

    def _opened(self) -> Any:
        if self._real is None:
            import serial

            self._real = serial.Serial(*self._device, timeout=0, write_timeout=STUCK_S, exclusive=True)
        return self._real

    def _shut(self) -> None:
        real, self._real = self._real, None
        if real is not None:
            real.close()
