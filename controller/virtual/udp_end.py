"""The far end of a wire on UDP: its socket, and the thread that hears it."""

import socket
from collections.abc import Callable
from contextlib import suppress

from controller.system.thread import SupervisedThread

Sender = tuple[str, int]
HEAR_S = 0.05


class UdpEnd:
    """Open from `plug` to `unplug`; what comes goes to `take`, and `look` is called when nothing comes for `hear_s`."""

    def __init__(
        self,
        name: str,
        take: Callable[[bytes, Sender], None],
        look: Callable[[], None] = lambda: None,
        hear_s: float = HEAR_S,
    ) -> None:
        self._name, self._take, self._look, self._hear_s = name, take, look, hear_s
        self._open: socket.socket | None = None

    @property
    def is_open(self) -> bool:
        """Whether it is plugged in."""
        return self._open is not None

    def plug(self, address: str, port: int, options: tuple[tuple[int, int, bytes | int], ...] = ()) -> int:
        """Begin to hear; the port, which is chosen where `port` is 0. Raises OSError."""
        here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            here.bind((address, port))
            for option in options:
                here.setsockopt(*option)
        except OSError:
            here.close()
            raise
        here.settimeout(self._hear_s)
        self._open = here
        self._thread = SupervisedThread(self._name, lambda: self._hear(here))
        self._thread.start()
        return int(here.getsockname()[1])

    def unplug(self) -> None:
        """Hear and say nothing any more."""
        here, self._open = self._open, None
        if here is not None:
            self._thread.stop()
            here.close()

    def send(self, data: bytes, to: Sender) -> None:
        """Lost where it is not plugged in, or where nothing hears it."""
        here = self._open
        if here is not None:
            with suppress(OSError):
                here.sendto(data, to)

    def _hear(self, here: socket.socket) -> None:
        while self._open is here:
            try:
                self._take(*here.recvfrom(65535))
            except TimeoutError:
                self._look()
            except OSError:  # an earlier answer found nothing at the other end
                continue


def free_udp_port(address: str) -> int:
    """One that is free now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        asked.bind((address, 0))
        return int(asked.getsockname()[1])
