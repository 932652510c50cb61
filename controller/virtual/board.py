"""A serial board that is not there: the firmware itself, built for this machine, on a pseudo-terminal.

The board's sensors and valves are words in a file that it shares with the plant (`firmware/host/shared.h`).
"""

import contextlib
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time
import weakref
from pathlib import Path

import numpy as np

from controller.arrays import Words
from controller.drivers.valves.serial_board.frames import OPENING_END, SUPPLY_CUT, TAKES_RAW, VENTED
from controller.errors import TendrilError
from controller.realtime.priority import prefer_session
from controller.schema.hardware import CHANNELS
from controller.system.child import end_now
from controller.system.thread import SupervisedThread
from controller.virtual.firmware import WATCHDOG_MS, built_firmware
from controller.virtual.peers import Drive, ReadPressures, TakeDrive

MAGIC = 0x314C52444E54
WORDS = 58
PRESSURES, E_STOP, STEPS = slice(1, 17), 17, 18
SETPOINTS, OPENINGS = slice(19, 35), slice(35, 51)
FLAGS, REASONS, LAST_COMMAND, VENTED_AT, REJECTED, BOOT = range(51, 57)
HOLD_BACK = 57
BROKEN = np.iinfo(np.int64).min
STEP_S = 1e-3
"""How often plant and board are told of each other [s]."""
HANGS = 0.12
"""A chip that hangs for so long is reset by its own watchdog, and valves without current vent [s]."""
PATIENCE_MS = 5000
"""Longest wait for the terminal."""


class BoardPeer:
    """A ValvePeer: eight channels. Its terminal has one name, whichever the system gives it after each plug."""

    def __init__(
        self, read_pressures: ReadPressures, take_drive: TakeDrive, port: Path | None = None, patience: float = 0.0
    ) -> None:
        """`port`: where its terminal is to be found; None: in a folder of its own. Its watchdog waits `patience` [s]
        where that is more than a board has: for a machine that pauses.

        Builds the firmware where that has not been done; raises TendrilError where there is no compiler, and where
        something is at `port` that no virtual board has left there: a real board, perhaps.
        """
        if port is not None and os.path.lexists(port) and not _left_over(port):
            raise TendrilError(f"valves.options.port = {port} is there already: name a path that is not")
        self._read_pressures, self._take_drive = read_pressures, take_drive
        self._program = built_firmware(max(WATCHDOG_MS, round(1e3 * patience)))
        self._folder = Path(tempfile.mkdtemp(prefix="tendril-board-"))
        self._forgotten = weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        self._port = port or self._folder / "tty"
        self.words: Words = np.memmap(self._folder / "shared", np.int64, "w+", shape=(WORDS,))
        self.words[0] = MAGIC
        self._process: subprocess.Popen[bytes] | None = None
        self._wires = SupervisedThread("board-peer", self._couple)

    @property
    def options(self) -> dict[str, str | int]:
        """For the driver "serial"."""
        return {"port": str(self._port)}

    @property
    def process(self) -> int:
        """Of the firmware, its id; raises OSError where it does not run."""
        return self._alive().pid

    def plug(self) -> None:
        """Give the board power if it has none, and plug in its cable; raises OSError."""
        if self._process is None or self._process.poll() is not None:
            self.power_off()
            self._start()
        elif self._port.is_symlink():
            return
        else:
            self._tell(b"p")
        path = self._printed()
        self._port.unlink(missing_ok=True)
        self._port.symlink_to(path)

    def unplug(self) -> None:
        """Pull the cable. The board goes on, and vents when its watchdog finds that no one speaks."""
        with contextlib.suppress(OSError):
            self._tell(b"u")
        self._port.unlink(missing_ok=True)

    def reset(self) -> None:
        """Its reset button: it begins again, with the cable in."""
        self._tell(b"r")

    def half_frame(self) -> None:
        """Its next answer is cut in half."""
        self._tell(b"h")

    def hold_back(self, seconds: float) -> None:
        """Each answer leaves so much later [s], as through an adapter that waits for more; 0: at once."""
        self.words[HOLD_BACK] = round(1e6 * seconds)

    def freeze(self) -> None:
        """Its program hangs: it says nothing more, and after 120 ms the chip's own watchdog lets go of the valves."""
        self._alive().send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        """After `freeze`: it begins again."""
        self._tell(b"r")
        self._alive().send_signal(signal.SIGCONT)

    def press_e_stop(self, pressed: bool) -> None:
        """The hardware stop at the board."""
        self.words[E_STOP] = pressed

    def power_off(self) -> None:
        """Everything without current: valves vent, supply closed, no port. `plug` gives it power again."""
        process, self._process = self._process, None
        self._port.unlink(missing_ok=True)
        if process is None:
            return
        end_now(process)

    def close(self) -> None:
        """End the firmware and its thread, and remove what it left."""
        self.power_off()
        self._wires.stop()
        self._forgotten()

    def _start(self) -> None:
        boot = int(self.words[BOOT]) % 65535 + 1
        command = [str(self._program), str(self._folder / "shared"), "--boot", str(boot)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, start_new_session=True
        )
        prefer_session(self._process.pid)
        if not self._wires.started:
            self._wires.start()

    def _alive(self) -> "subprocess.Popen[bytes]":
        if self._process is None or self._process.poll() is not None:
            raise OSError("the board has no power")
        return self._process

    def _tell(self, asked: bytes) -> None:
        pipe = self._alive().stdin
        assert pipe is not None
        pipe.write(asked)

    def _printed(self) -> str:
        """The terminal's path, of which the firmware says where it is."""
        pipe = self._alive().stdout
        assert pipe is not None
        waiting = select.poll()
        waiting.register(pipe, select.POLLIN)
        path = pipe.readline().decode().strip() if waiting.poll(PATIENCE_MS) else ""
        if not path:
            raise OSError("the board's firmware opens no terminal")
        return path

    def _couple(self) -> None:
        """Sensors in, valves out, once a millisecond."""
        steps, stepped = -1, time.monotonic()
        while not self._wires.wait(STEP_S):
            self._sense()
            if self.words[STEPS] != steps:
                steps, stepped = int(self.words[STEPS]), time.monotonic()
                self._take_drive(self._drive())
            elif time.monotonic() - stepped > HANGS:
                self._take_drive(without_current())

    def _sense(self) -> None:
        sensed = np.asarray(self._read_pressures(), float)
        known = np.isfinite(sensed)
        self.words[PRESSURES] = np.where(known, np.rint(np.where(known, sensed, 0.0)), BROKEN)

    def _drive(self) -> Drive:
        flags = int(self.words[FLAGS])
        return Drive(
            pressures=np.array(self.words[SETPOINTS], float),
            openings=np.array(self.words[OPENINGS], float) / OPENING_END,
            raw=bool(flags & TAKES_RAW),
            vent=bool(flags & VENTED),
            cut=bool(flags & SUPPLY_CUT),
        )


def _left_over(port: Path) -> bool:
    """Whether this is the link of a virtual board that was killed."""
    return port.is_symlink() and not port.exists() and os.readlink(port).startswith("/dev/pts/")


def without_current() -> Drive:
    """What valves do that no one drives: exhausts are open, the supply is closed."""
    return Drive(np.zeros(CHANNELS), np.full(CHANNELS, -1.0), raw=False, vent=True, cut=True)
