"""A board made of a function, at a pseudo-terminal: for answers that no firmware gives."""

import os
import queue
import struct
import threading
import time
import tty
from collections.abc import Callable

from controller.drivers.valves.serial_board import frames

Answers = Callable[[bytes], bytes]


class FarEnd:
    """A board made of a function: a question's body in, bytes out."""

    def __init__(self, answers: Answers, delay: float = 0.0) -> None:
        """`delay` from a question to its answer [s], however many are on their way."""
        self._answers, self._delay = answers, delay
        self._due: queue.Queue[tuple[float, bytes]] = queue.Queue()
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self.frames = 0
        self._stopping = False
        self._threads = [threading.Thread(target=serve, daemon=True) for serve in (self._serve, self._send)]
        for thread in self._threads:
            thread.start()

    def _serve(self) -> None:
        rest = b""
        while not self._stopping:
            *ended, rest = (rest + os.read(self._master, 4096)).split(b"\0")
            for part in ended:
                if part and part != b"end":
                    self.frames += 1
                    self.say(self._answers(frames.opened(part)))

    def say(self, data: bytes) -> None:
        """Send `data` after the delay."""
        self._due.put((time.monotonic() + self._delay, data))

    def _send(self) -> None:
        while not self._stopping:
            due, data = self._due.get()
            time.sleep(max(0.0, due - time.monotonic()))
            os.write(self._master, data)

    def close(self) -> None:
        self._stopping = True
        os.write(self._slave, b"\0end\0")
        self._due.put((0.0, b""))
        for thread in self._threads:
            thread.join()
        os.close(self._master)
        os.close(self._slave)


def hello_reply(asked: bytes, version: int = 1, channels: int = 4, can: int = 15, boot: int = 1) -> bytes:
    head = struct.pack("<BBHII", version, 0x81, *struct.unpack_from("<HI", asked, 2), 5000)
    return frames.sealed(
        head + struct.pack("<HHBBHiii16s", 256, boot, channels, can, 100, 300_000, 340_000, 10**7, b"x")
    )


def state(asked: bytes, later: int = 0, pressure: int = 1000, channels: int = 4, boot: int = 1) -> bytes:
    sequence, host_us = struct.unpack_from("<HI", asked, 2)
    head = struct.pack("<BBHI", 1, 0x82, (sequence + later) % 65536, host_us)
    body = struct.pack("<IIHHBBBB", 6000, 5900, boot, 0, 0, 0, channels, 0)
    return frames.sealed(head + body + struct.pack(f"<{channels}i", *[pressure] * channels))
