"""`tendril virtual-rig`: the simulated plant behind the wires that a rig file names, in real time, with faults.

What is typed into it, a line each, breaks it as real devices break: see `FAULTS`. Each is answered by a line of JSON.
"""

import io
import json
import math
import os
import random
import shlex
import signal
import stat
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from controller.arrays import Array
from controller.drivers.twin import inject
from controller.errors import ParameterError, TendrilError
from controller.schema.hardware import CHANNELS, Frame, MotionCapture, Valves
from controller.schema.messages import TwinFaults
from controller.schema.parameters import SENSORS
from controller.schema.rig_file import RigFile, changed, read_rig_file
from controller.system.thread import SupervisedThread
from controller.system.whole_file import write_whole
from controller.virtual.board import BoardPeer
from controller.virtual.peers import LATENCY, CapturePeer, Drive, Peer
from controller.virtual.plant import RunningPlant
from controller.virtual.registry import capture_peer, valve_peer

POLL_S = 5e-4
"""Pause between two looks for a new sample [s]."""
CHAMBERS = 4
FRAMES_TOLD = 100
"""Their latency is told, where someone asks."""
WAND = "wand"
"""Its name, where the camera gives names."""
GHOST_RANGE = 0.4
"""Ghosts are seen this far from the base at most [m]."""


class Camera:
    """Shows the plant's markers to the client behind `peer`, as the rig file says that they are seen."""

    def __init__(self, asked: MotionCapture, plant: RunningPlant, peer: CapturePeer) -> None:
        self._asked, self._plant, self.peer = asked, plant, peer
        self.late, self.ghosts = 0.0, 0
        self.swapped: tuple[int, int] | None = None
        self.wand: tuple[float, float] | None = None
        self.hidden: set[int] = set()
        self._names = {rod: name for name, rod in asked.labels.items()}
        self._random = random.Random(1)
        self._waiting: deque[tuple[int, Array]] = deque()
        self._ages_ns: deque[int] = deque(maxlen=FRAMES_TOLD)
        self._thread = SupervisedThread("camera", self._run)

    def start(self) -> None:
        """Begin to show what the plant's own camera sees."""
        self.peer.plug()
        self._thread.start()

    def latency(self) -> float:
        """How old frames were when they left, mean of the last ones [s]; nan before the first.

        A little more than what was asked for: this thread looks now and then, and takes a while to send.
        """
        ages = list(self._ages_ns)
        return sum(ages) * 1e-9 / len(ages) if ages else math.nan

    def stop(self) -> None:
        """End the thread and the wire."""
        self._thread.stop()
        self.peer.unplug()

    def _run(self) -> None:
        seen = 0
        while not self._thread.wait(POLL_S):
            newest = self._plant.newest()
            if newest["t_ns"] != seen:
                seen = int(newest["t_ns"])
                self._waiting.append((seen, np.array(newest["markers"])))
            late_ns = int(self.late * 1e9)
            while self._waiting and time.monotonic_ns() >= self._waiting[0][0] + late_ns:
                self._show(*self._waiting.popleft())

    def _show(self, t_ns: int, markers: Array) -> None:
        rods = [rod for rod in self._asked.rods if rod not in self.hidden]
        places = {rod: markers[rod - 1] for rod in rods}
        if self.swapped is not None and set(self.swapped) <= set(places):
            a, b = self.swapped
            places[a], places[b] = places[b], places[a]
        points = [places[rod] for rod in rods] + [self._ghost() for _ in range(self.ghosts)]
        labels = [self._names.get(rod, "") for rod in rods] + [""] * self.ghosts
        if self.wand is not None:
            points.append(np.array(self.wand))
            labels.append(WAND if self._names else "")
        self.peer.show(t_ns, seen_by_camera(np.array(points).reshape(-1, 2), self._asked.frame), tuple(labels))
        self._ages_ns.append(time.monotonic_ns() - t_ns)

    def _ghost(self) -> Array:
        return np.array([self._random.uniform(-GHOST_RANGE, GHOST_RANGE) for _ in range(2)])


def seen_by_camera(plane: Array, frame: Frame) -> Array:
    """Points (M,3) [m] in the camera's coordinates that `frame` carries to `plane` (M,2): the nearest such ones."""
    axes: Array = np.linalg.pinv(np.array(frame.axes))
    points: Array = (plane - np.array(frame.origin)) @ axes.T
    return points


class Board:
    """Between the plant's four chambers and a board's channels."""

    def __init__(self, asked: Valves, plant: RunningPlant) -> None:
        self._channels, self._plant = np.array(asked.chambers), plant

    def pressures(self) -> Array:
        """What the sensors at the board's channels show, (16,) [Pa]."""
        shown = np.zeros(CHANNELS)
        shown[self._channels] = self._plant.newest()["pressures"]
        return shown

    def drive(self, asked: Drive) -> None:
        """The board drives its valves."""
        self._plant.drive(asked.pressures[self._channels], asked.openings[self._channels], asked.vent, asked.cut)


class VirtualRig:
    """Plant, camera and board; `start`, and break it with `do`."""

    def __init__(self, found: RigFile, folder: Path, plant: str = "") -> None:
        """`plant` "rod" or "cosserat", else that of the file. Raises ParameterError."""
        if plant not in ("", "rod", "cosserat"):
            raise ParameterError(f"plant = {plant!r} is not rod or cosserat")
        twin = found.twin.model_copy(update={"plant": plant} if plant else {})
        parameters = found.parameters(folder).model_copy(update={"twin": twin})
        self.plant = RunningPlant(parameters, raw=found.valves.command == "opening")
        board = Board(found.valves, self.plant)
        seen, driven = found.motion_capture, found.valves
        self.camera = Camera(seen, self.plant, capture_peer(seen.driver, seen.options))
        patience = parameters.limits.pressures_lost
        self.valves = valve_peer(driven.driver, driven.options, board.pressures, board.drive, patience)
        self._asked = {"motion_capture": addresses(seen.options), "valves": addresses(driven.options)}
        self._faults = TwinFaults()

    def start(self) -> None:
        """Let plant and wires go; TendrilError names the wire whose address cannot be had."""
        self.plant.start()
        for wire, begin in (("valves", self.valves.plug), ("motion_capture", self.camera.start)):
            try:
                begin()
            except OSError as error:
                self.stop()
                raise TendrilError(f"{wire} cannot begin at {self._asked[wire]}: {error.strerror or error}") from error

    def stop(self) -> None:
        """End everything."""
        self.camera.stop()
        self.valves.close()
        self.plant.stop()

    def addresses(self) -> dict[str, str | int]:
        """Where the devices are, as changes to the rig file."""
        found: dict[str, str | int] = {}
        for table, peer in (("motion_capture", self.camera.peer), ("valves", self.valves)):
            found |= {f"{table}.options.{name}": value for name, value in peer.options.items()}
        return found

    def do(self, line: str) -> str:
        """Carry out one line, as "late 0.03"; says what it did. Raises ParameterError."""
        try:
            name, *words = shlex.split(line)
            if name not in FAULTS:
                raise ParameterError(f"{name!r} is not one of {', '.join(FAULTS)}")
            FAULTS[name](self, *words)
        except ParameterError:
            raise
        except (TypeError, ValueError, AttributeError) as error:
            raise ParameterError(f"{line!r}: {error}") from error
        return line

    def inject(self, **faults: object) -> None:
        """What breaks in the plant itself."""
        self._faults = TwinFaults.model_validate(self._faults.model_dump() | faults)
        inject(self._faults, self.plant.plant.faults)

    def wire(self, name: str) -> Peer:
        """The device `name`."""
        wires: dict[str, Peer] = {"camera": self.camera.peer, "valves": self.valves}
        if name not in wires:
            raise ValueError(f"{name} is not camera or valves")
        return wires[name]

    def mend(self) -> None:
        """Everything as it was; what is unplugged stays so."""
        self._faults = TwinFaults()
        inject(self._faults, self.plant.plant.faults)
        self.camera.late, self.camera.ghosts, self.camera.swapped = 0.0, 0, None
        self.camera.hidden.clear()
        self.camera.wand = None
        if isinstance(self.valves, BoardPeer):
            self.valves.hold_back(0.0)


def addresses(options: dict[str, Any]) -> str:
    """Those that `options` name, as "server = 127.0.0.1, command_port = 1510"."""
    found = [f"{name} = {options[name]}" for name in options if name.endswith(("host", "server", "address", "port"))]
    return ", ".join(found) or "a free address"


def _within(name: str, text: str, low: float, high: float) -> float:
    value = float(text)
    if not low <= value <= high:
        raise ValueError(f"{name} = {text} is outside [{low:g}, {high:g}]")
    return value


def _touch(rig: VirtualRig, x: str, y: str = "") -> None:
    off = (x, y) == ("off", "")
    rig.camera.wand = None if off else (_within("x", x, -1.0, 1.0), _within("y", y or "nan", -1.0, 1.0))


def _board(rig: VirtualRig) -> BoardPeer:
    if not isinstance(rig.valves, BoardPeer):
        raise ValueError('answers are held back by valves.driver = "serial" only')
    return rig.valves


def _rod(value: str) -> int:
    rod = int(value)
    if not 1 <= rod <= SENSORS:
        raise ValueError(f"rod = {rod} is outside [1, {SENSORS}]")
    return rod


def _chamber(value: str) -> int:
    chamber = int(value)
    if not 1 <= chamber <= CHAMBERS:
        raise ValueError(f"chamber = {chamber} is outside [1, {CHAMBERS}]")
    return 1 << (chamber - 1)


FAULTS: dict[str, Callable[..., None]] = {
    "unplug": lambda rig, name: rig.wire(name).unplug(),
    "plug": lambda rig, name: rig.wire(name).plug(),
    "late": lambda rig, late: setattr(rig.camera, "late", _within("late", late, 0.0, 10.0)),
    "ghosts": lambda rig, count: setattr(rig.camera, "ghosts", int(_within("ghosts", count, 0, 500))),
    "wand": _touch,
    "swap": lambda rig, a, b: setattr(rig.camera, "swapped", (_rod(a), _rod(b))),
    "hide": lambda rig, rod: rig.camera.hidden.add(_rod(rod)),
    "noise": lambda rig, sigma: rig.inject(noise=float(sigma)),
    "stick": lambda rig, chamber: rig.inject(valves_stuck=_chamber(chamber)),
    "stick_sensor": lambda rig, chamber: rig.inject(sensors_stuck=_chamber(chamber)),
    "supply_off": lambda rig: rig.inject(supply_lost=True),
    "reset": lambda rig: rig.valves.reset(),
    "freeze": lambda rig: rig.valves.freeze(),
    "thaw": lambda rig: rig.valves.thaw(),
    "half": lambda rig: rig.valves.half_frame(),
    "hold_back": lambda rig, seconds: _board(rig).hold_back(_within("hold_back", seconds, 0.0, 1.0)),
    "mend": lambda rig: rig.mend(),
}
"""What a line may begin with: camera and valves are unplugged and plugged, samples are `late` [s] beyond the camera's
own latency, `ghosts` are seen, a `wand` touches a place of the plane [m] or none (`off`), two rods' markers are
`swap`ped, one is `hide`den, `noise` [m] is added, a valve or a pressure sensor (1 to 4: u1+, u1-, u2+, u2-) sticks, the
supply is lost, the board is `reset`, frozen and thawed, its next answer is cut in `half`, those of a serial board are
held back (`hold_back` [s]); `mend` ends all that is not unplugged."""


def run_virtual_rig(path: Path, plant: str, out: Path | None, lines: TextIO = sys.stdin) -> None:
    """Run until the lines end or Ctrl-C; `out` is written once the wires answer. Raises TendrilError."""
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell may have started us in the background, SIGINT ignored
        signal.signal(number, signal.default_int_handler)
    if isinstance(lines, io.TextIOWrapper):
        lines.reconfigure(errors="backslashreplace")  # bytes that are not UTF-8 are refused, as an unknown fault is
    found = read_rig_file(path)
    try:
        rig = VirtualRig(found, path.parent, plant)
        rig.start()
    except TendrilError as error:
        raise TendrilError(f"{path}: {error}") from error
    try:
        _say({"ready": found.name, **rig.addresses()})
        if out is not None:
            write_whole(out, changed(path.read_text(), rig.addresses(), str(out)))
        _obey(rig, lines)
    except KeyboardInterrupt:
        pass
    finally:
        rig.stop()


def _obey(rig: VirtualRig, lines: TextIO) -> None:
    """Line after line; where no one can type, until Ctrl-C or SIGTERM."""
    for line in lines:
        if not line.strip():
            continue
        try:
            _say({LATENCY: rig.camera.latency()} if line.strip() == LATENCY else {"done": rig.do(line.strip())})
        except (TendrilError, OSError) as error:
            _say({"refused": str(error)})
    if _nobody_there(lines):
        threading.Event().wait()


def _nobody_there(lines: TextIO) -> bool:
    """Whether lines end because no one could type any, as in the background: /dev/null, not a closed pipe or Ctrl-D."""
    return not lines.isatty() and stat.S_ISCHR(os.fstat(lines.fileno()).st_mode)


def _say(message: dict[str, object]) -> None:
    print(json.dumps(message), flush=True)
