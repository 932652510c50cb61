"""One connection to a Modbus TCP device: a request, its answer, and whatever else may come instead.

Requests and answers are pymodbus's. The socket is ours, not that of its client: that one connects again by itself,
which would pass over a device's start-up, and may wait for twice its timeout.
"""

import logging
import socket
import struct
import time
from typing import NamedTuple

from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadInputRegistersRequest,
    ReadWriteMultipleRegistersRequest,
    WriteMultipleRegistersRequest,
    WriteSingleRegisterRequest,
)

from controller.drivers.device import DeviceError

logging.getLogger("pymodbus.logging").setLevel(logging.CRITICAL)  # it logs each bad frame; we count them

HEADER = struct.Struct(">HHHB")
"""Transaction, protocol (0), bytes that follow, unit."""
LENGTH_MAX_BYTES = 254
"""Most bytes after the length field: unit and 253 of function and data."""
UNANSWERED = 5
"""Requests in succession without an answer, after which a connection is held to be dead."""
BUSY = (5, 6)
"""Exceptions that pass: acknowledged and being worked on; busy."""
EXCEPTIONS = {
    1: "does not know the function",
    2: "has no such register",
    3: "refuses the value",
    4: "failed",
    10: "has no way to the unit",
    11: "gets no answer from the unit",
}
ILLEGAL_FUNCTION = 1


class Refused(DeviceError):
    """The device answered with an exception."""

    def __init__(self, text: str, code: int) -> None:
        super().__init__(text)
        self.code = code


class Frame(NamedTuple):
    """What came under one header."""

    transaction: int
    unit: int
    body: bytes
    """Function and data."""


def take_frame(buffer: bytearray) -> Frame | None:
    """Cut the first whole frame off `buffer`; None if there is none yet. DeviceError where no frame can begin."""
    if len(buffer) < HEADER.size:
        return None
    transaction, protocol, length, unit = HEADER.unpack_from(buffer)
    if protocol != 0 or not 2 <= length <= LENGTH_MAX_BYTES:
        raise DeviceError(f"the device speaks no Modbus: protocol {protocol}, length {length}")
    end = HEADER.size - 1 + length
    if len(buffer) < end:
        return None
    body = bytes(buffer[HEADER.size : end])
    del buffer[:end]
    return Frame(transaction, unit, body)


def registers_of(body: bytes, request: ModbusPDU, decoder: DecodePDU) -> list[int] | None:
    """Registers in the answer `body` to `request`, [] to a write; None for anything else.

    Raises Refused for an exception. Byte counts are checked here, because pymodbus takes what is there.
    """
    answer = decoder.decode(body)
    if answer is None or answer.function_code & 0x7F != request.function_code:
        return None
    if answer.function_code & 0x80:
        if len(body) == 2 and answer.exception_code not in BUSY:
            raise refusal(answer.exception_code)
        return None
    if isinstance(request, WriteMultipleRegistersRequest):
        echoed = (answer.address, answer.count) == (request.address, request.count)
        return [] if echoed and len(body) == 5 else None
    if isinstance(request, WriteSingleRegisterRequest):
        echoed = (answer.address, answer.registers) == (request.address, request.registers)
        return [] if echoed and len(body) == 5 else None
    wanted = request.read_count if isinstance(request, ReadWriteMultipleRegistersRequest) else request.count
    whole = len(body) == 2 + 2 * wanted and body[1] == 2 * wanted
    return list(answer.registers) if whole and len(answer.registers) == wanted else None


def refusal(code: int) -> Refused:
    """The exception `code` in words."""
    return Refused(f"the device {EXCEPTIONS.get(code, 'answers with an exception')} (code {code})", code)


class Wire:
    """A connection, and what was wrong with what came."""

    def __init__(self, host: str, port: int, unit: int, single: bool = False) -> None:
        """`single`: each register is written by a request of its own, function 6."""
        self._at, self._unit, self._single = (host, port), unit, single
        self._socket: socket.socket | None = None
        self._buffer = bytearray()
        self._decoder = DecodePDU(False)
        self._framer = FramerSocket(self._decoder)
        self._transaction = self._unanswered = 0
        self.rejected = 0

    def connect(self, timeout: float) -> None:
        """Within `timeout` [s]; OSError where no one listens."""
        self.close()
        try:
            found = socket.create_connection(self._at, timeout=timeout)
        except OSError as error:
            raise DeviceError(f"no connection to {self._at[0]}:{self._at[1]}: {error.strerror or error}") from error
        found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # What a pulled cable holds back must not reach the valves when it is plugged in again: closing drops it.
        found.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._socket, self._unanswered = found, 0
        self._buffer.clear()

    def close(self) -> None:
        """Never raises; a thread that waits for an answer is woken."""
        gone, self._socket = self._socket, None
        if gone is None:
            return
        try:
            gone.shutdown(socket.SHUT_RDWR)
        except OSError:  # the other end was first
            pass
        gone.close()

    def read(self, start: int, count: int, timeout: float, inputs: bool = False) -> list[int] | None:
        """`count` registers from `start`; None if they do not come within `timeout` [s]."""
        kind = ReadInputRegistersRequest if inputs else ReadHoldingRegistersRequest
        return self._ask(kind(address=start, count=count, dev_id=self._unit), timeout)

    def write(self, start: int, values: list[int], timeout: float) -> bool:
        """Write `values` from register `start`; whether the device said so within `timeout` [s]."""
        if self._single:
            return self._write_each(start, values, time.monotonic() + timeout)
        request = WriteMultipleRegistersRequest(address=start, registers=values, dev_id=self._unit)
        return self._ask(request, timeout) is not None

    def _write_each(self, start: int, values: list[int], until: float) -> bool:
        for register, value in enumerate(values, start):
            request = WriteSingleRegisterRequest(address=register, registers=[value], dev_id=self._unit)
            if self._ask(request, max(0.0, until - time.monotonic())) is None:
                return False
        return True

    def write_read(self, write: tuple[int, list[int]], read: tuple[int, int], timeout: float) -> list[int] | None:
        """Write values from a register, then read a count from a register, in one request."""
        request = ReadWriteMultipleRegistersRequest(read[0], read[1], write[0], write[1], dev_id=self._unit)
        return self._ask(request, timeout)

    def _ask(self, request: ModbusPDU, timeout: float) -> list[int] | None:
        until = time.monotonic() + timeout
        self._transaction = self._transaction % 65535 + 1
        request.transaction_id = self._transaction
        self._send(self._framer.buildFrame(request), timeout)
        try:
            answer = self._answer(request, until)
        except TimeoutError:
            answer = None
        self._unanswered = 0 if answer is not None else self._unanswered + 1
        if self._unanswered >= UNANSWERED:
            raise DeviceError(f"no answer to {UNANSWERED} requests")
        return answer

    def _send(self, frame: bytes, timeout: float) -> None:
        here = self._connected()
        here.settimeout(max(timeout, 1e-3))
        try:
            here.sendall(frame)
        except TimeoutError as error:  # part of it may be gone, so nothing can follow it
            raise DeviceError("the device takes no requests any more") from error

    def _answer(self, request: ModbusPDU, until: float) -> list[int] | None:
        while (left := until - time.monotonic()) > 0.0:
            found = self.take(self._received(left), request)
            if found is not None:
                return found
        return None

    def take(self, data: bytes, request: ModbusPDU) -> list[int] | None:
        """Registers in the answer to `request` among what came, `data` after all before it; None if it is not there.

        Whatever else is a frame is counted. Raises Refused, and DeviceError where no frame can begin.
        """
        self._buffer += data
        while frame := self._frame():
            if (frame.transaction, frame.unit) == (request.transaction_id, self._unit):
                found = registers_of(frame.body, request, self._decoder)
                if found is not None:
                    return found
            self.rejected += 1
        return None

    def _frame(self) -> Frame | None:
        try:
            return take_frame(self._buffer)
        except DeviceError:
            self.rejected += 1
            raise

    def _received(self, timeout: float) -> bytes:
        here = self._connected()
        here.settimeout(timeout)
        data = here.recv(4096)
        if not data:
            raise DeviceError("the device closed the connection")
        return data

    def _connected(self) -> socket.socket:
        if self._socket is None:
            raise DeviceError("not connected")
        return self._socket
