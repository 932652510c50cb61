"""Between a driver and its real device: keeps what leaves, holds it back, and pulls the cable where a check wants it.

So a driver of which nothing else is known is tried on its own wire, with the device that is there.
"""

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from controller.drivers.conformance.bench import Driven
from controller.drivers.conformance.relays import relay_for

KEPT = 4096
"""Pieces of what left that are kept."""

Decode = Callable[[bytes], Driven | None]
"""What the bytes of a command tell the valves, None where they are none: by the device's manual, not by the driver."""


class Recorder:
    """A Bench whose device is the real one."""

    def __init__(self, options: dict[str, Any], decode: Decode | None = None) -> None:
        """`options` of the driver, whole: they name the device. Raises ParameterError where it is at no known wire.

        Raises OSError where there is no port to be had.
        """
        self._relay = relay_for(options, self._passes)
        self._decode = decode
        self._lock = threading.Lock()
        self._left: deque[bytes] = deque(maxlen=KEPT)
        self._unread: deque[bytes] = deque(maxlen=KEPT)
        self._told: Driven | None = None
        self._goes_out = self._comes_in = True
        self._relay.start()

    @property
    def decodes(self) -> bool:
        """Whether it is known what the bytes mean."""
        return self._decode is not None

    @property
    def options(self) -> dict[str, str | int]:
        """By which the driver takes this way."""
        return self._relay.options

    def plug(self) -> None:
        """Carry everything both ways."""
        self._goes_out = self._comes_in = True
        self._relay.start()

    def unplug(self) -> None:
        """Drop every connection."""
        self._relay.stop()

    def silence(self) -> None:
        """Carry nothing, over connections that stay."""
        self._goes_out = self._comes_in = False

    def hold(self) -> None:
        """From now on keep what leaves, and pass nothing of it on; `plug` ends that."""
        self._goes_out = False
        with self._lock:
            self._left.clear()
            self._unread.clear()
            self._told = None

    def left(self) -> bytes:
        """What left for the device since `hold`."""
        with self._lock:
            return b"".join(self._left)

    def driven(self) -> Driven | None:
        """What the newest command told the valves; None without `decode`."""
        if self._decode is None:
            return None
        while self._unread:
            told = self._decode(self._unread.popleft())
            self._told = told if told is not None else self._told
        return self._told

    def close(self) -> None:
        """End everything."""
        self._relay.stop()

    def _passes(self, data: bytes, leaves: bool) -> bool:
        if not leaves:
            return self._comes_in
        with self._lock:
            self._left.append(data)
            self._unread.append(data)
        return self._goes_out
