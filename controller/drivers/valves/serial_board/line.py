"""A serial line: opened for us alone, and without any wait but the one that is asked for."""

import os
import select
import time

import serial

from controller.drivers.device import DeviceError

AT_ONCE = 4096
"""Bytes that are read in one go at most."""
GONE = select.POLLHUP | select.POLLERR | select.POLLNVAL


class Line:
    """pyserial opens and sets up the port; its own reads set the whole port up again for each new timeout."""

    def __init__(self, path: str, baud: int) -> None:
        """Open it; raises OSError where there is none, it is not ours, or another program has it."""
        self._port = serial.Serial(path, baud, timeout=0, write_timeout=0, exclusive=True)
        self._file = self._port.fileno()
        self._poll = select.poll()
        self._poll.register(self._file, select.POLLIN)

    def write(self, data: bytes) -> bool:
        """Send `data`; False where the line takes no more now, and part of it may be lost. OSError: it is gone."""
        try:
            return os.write(self._file, data) == len(data)
        except BlockingIOError:
            return False

    def read(self, deadline: float) -> bytes:
        """What has come, b"" if nothing has by `deadline` on the monotonic clock [s]; DeviceError: it is gone."""
        ready = self._poll.poll(max(0.0, deadline - time.monotonic()) * 1e3)
        if not ready:
            return b""
        try:
            data = os.read(self._file, AT_ONCE)
        except BlockingIOError:
            data = b""
        if not data and ready[0][1]:
            raise DeviceError("the line is gone: is its cable still plugged in?")
        return data

    def forget(self) -> None:
        """Throw away what has come and not been read."""
        self._port.reset_input_buffer()

    def close(self) -> None:
        """Let go of the port."""
        try:
            self._port.close()
        except OSError:
            pass  # of a line that is gone there is nothing left
