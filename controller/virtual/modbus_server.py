"""A Festo VTEM on Modbus TCP that is not there: pymodbus's own server, with registers coupled to a plant."""

import asyncio
import threading
import time
from collections.abc import Coroutine
from typing import Any

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from controller.system.thread import SupervisedThread
from controller.virtual.peers import ReadPressures, TakeDrive
from controller.virtual.vtem_terminal import DUMP, INPUTS, OUTPUT_WORDS, OUTPUTS, WATCHDOG, VtemTerminal

POLL_S = 0.005
"""How often the terminal's watchdog is looked at [s]."""


class ModbusPeer:
    """A ValvePeer. Faults are attributes: set them at any time, from any thread."""

    def __init__(self, read_pressures: ReadPressures, take_drive: TakeDrive, port: int = 0, unit: int = 1) -> None:
        """On a free port if `port` is 0; it keeps it when it is plugged in again."""
        self.terminal = VtemTerminal(read_pressures, take_drive)
        self.silent = False
        """As `freeze` has it."""
        self.exception = 0
        """Answers every request with this exception code."""
        self.unknown: set[int] = set()
        """Functions that it does not know."""
        self.late = 0.0
        """Answers so much later [s]."""
        self.requests = 0
        self._port, self._unit = port, unit
        self._loop: asyncio.AbstractEventLoop | None = None
        self._server: Any = None
        self._thread: SupervisedThread | None = None
        self._alone: threading.Timer | None = None
        self._half = False

    @property
    def options(self) -> dict[str, str | int]:
        """For the driver "modbus"."""
        return {"host": "127.0.0.1", "port": self._port, "unit": self._unit, "dump_register": DUMP}

    def plug(self) -> None:
        """Listen; raises OSError where the port is taken."""
        if self._thread is not None:
            return
        if self._alone is not None:
            self._alone.cancel()
        self._loop = asyncio.new_event_loop()
        self._thread = SupervisedThread("modbus-peer", self._loop.run_forever)
        self._thread.start()
        try:
            self._run(self._listen())
        except BaseException:
            self.unplug()
            raise

    def unplug(self) -> None:
        """Drop every connection at once. The terminal goes on by itself until its watchdog bites."""
        thread, loop = self._thread, self._loop
        if thread is None or loop is None:
            return
        self._run(self._drop())
        loop.call_soon_threadsafe(loop.stop)
        thread.stop()
        loop.close()
        self._thread = self._loop = self._server = None
        left = self.terminal.left(time.monotonic())
        if left is not None:
            self._alone = threading.Timer(left, lambda: self.terminal.look(time.monotonic()))
            self._alone.daemon = True
            self._alone.start()

    def close(self) -> None:
        """As `unplug`: nothing is left."""
        self.unplug()

    def freeze(self) -> None:
        """Take no request and give no answer, over connections that stay."""
        self.silent = True

    def thaw(self) -> None:
        """Answer again."""
        self.silent = False

    def reset(self) -> None:
        """The terminal loses its power for a moment: outputs, watchdog and connections are gone."""
        self.unplug()
        self.terminal.reset()
        self.plug()

    def half_frame(self) -> None:
        """Send only the first half of the next answer."""
        self._half = True

    def _run(self, work: Coroutine[Any, Any, None]) -> None:
        assert self._loop is not None
        asyncio.run_coroutine_threadsafe(work, self._loop).result(5.0)

    async def _listen(self) -> None:
        words = [
            SimData(OUTPUTS, values=[0] * OUTPUT_WORDS, datatype=DataType.REGISTERS),
            SimData(INPUTS, values=[0] * 40, datatype=DataType.REGISTERS, readonly=True),
            SimData(WATCHDOG, values=0, datatype=DataType.REGISTERS),
        ]
        device = SimDevice(self._unit, simdata=words, action=self._act)
        self._server = ModbusTcpServer(device, address=("127.0.0.1", self._port), trace_packet=self._packet)
        try:
            await self._server.serve_forever(background=True)
        except RuntimeError as error:
            raise OSError("it is taken, or not for this user") from error
        transport: Any = self._server.transport
        self._port = transport.sockets[0].getsockname()[1]
        self._watching = asyncio.get_running_loop().create_task(self._watch())

    async def _drop(self) -> None:
        if self._server is None or self._server.transport is None:
            return
        self._watching.cancel()
        for listening in self._server.transport.sockets:
            asyncio.get_running_loop().remove_reader(listening)
        await asyncio.sleep(0.01)  # who was just let in is one of the connections now
        for connection in list(self._server.active_connections.values()):
            if connection.transport is not None:
                connection.transport.abort()
        await self._server.shutdown()
        await asyncio.sleep(0.01)  # connections end

    async def _watch(self) -> None:
        while True:
            self.terminal.look(time.monotonic())
            await asyncio.sleep(POLL_S)

    def _packet(self, sending: bool, data: bytes) -> bytes:
        if sending and self.silent:
            return b""
        if sending and self._half:
            self._half = False
            return data[: len(data) // 2]
        return data

    async def _act(
        self, function: int, start: int, address: int, count: int, registers: list[int], values: Any
    ) -> ExcCodes | None:
        """Called by the server for each access to registers; `registers` are those from `start`, to be changed."""
        if self.silent:
            return ExcCodes.DEVICE_BUSY
        if self.late > 0.0:
            await asyncio.sleep(self.late)
        if self.exception or function in self.unknown:
            return ExcCodes(self.exception or ExcCodes.ILLEGAL_FUNCTION)
        self.requests += 1
        now = time.monotonic()
        if values is not None:
            self.terminal.write(address, [int(value) for value in values], now)
        else:
            self.terminal.heard(now)
        for register, word in self.terminal.registers(now).items():
            registers[register - start] = word
        return None
