import math
import random

import pytest
from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU, ExceptionResponse, ModbusPDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadHoldingRegistersResponse,
    ReadWriteMultipleRegistersRequest,
    ReadWriteMultipleRegistersResponse,
    WriteMultipleRegistersRequest,
    WriteMultipleRegistersResponse,
)

from controller.drivers.device import DeviceError
from controller.drivers.valves.modbus.registers import spans
from controller.drivers.valves.modbus.wire import Refused, Wire, take_frame
from controller.drivers.valves.modbus.words import Coding, Kind

ROUNDS = 100_000
UNIT = 1
BUILD = FramerSocket(DecodePDU(True)).buildFrame
EXCHANGES: list[tuple[ModbusPDU, ModbusPDU]] = [
    (
        ReadWriteMultipleRegistersRequest(45395, 6, 40003, [0] * 6, dev_id=UNIT, transaction_id=7),
        ReadWriteMultipleRegistersResponse(registers=[131, 1, 2, 131, 3, 4], dev_id=UNIT, transaction_id=7),
    ),
    (
        ReadHoldingRegistersRequest(address=45395, count=3, dev_id=UNIT, transaction_id=7),
        ReadHoldingRegistersResponse(registers=[131, 1, 2], dev_id=UNIT, transaction_id=7),
    ),
    (
        WriteMultipleRegistersRequest(address=40003, registers=[1, 2, 3], dev_id=UNIT, transaction_id=7),
        WriteMultipleRegistersResponse(address=40003, count=3, dev_id=UNIT, transaction_id=7),
    ),
]
REQUEST, ANSWER = EXCHANGES[0]


def wire() -> Wire:
    return Wire("127.0.0.1", 502, UNIT)


@pytest.mark.parametrize(("request_", "answer"), EXCHANGES)
def test_an_answer_may_come_byte_by_byte(request_: ModbusPDU, answer: ModbusPDU) -> None:
    data, here = BUILD(answer), wire()
    found = [here.take(data[i : i + 1], request_) for i in range(len(data))]
    assert found[:-1] == [None] * (len(data) - 1) and found[-1] == list(answer.registers)
    assert here.rejected == 0


@pytest.mark.parametrize(
    "wrong",
    [
        {"transaction_id": 6},
        {"dev_id": 2},
        {"registers": [1, 2, 3, 4, 5]},
        {"registers": [1, 2, 3, 4, 5, 6, 7]},
    ],
)
def test_an_answer_to_something_else_is_counted_and_the_right_one_taken(wrong: dict[str, object]) -> None:
    about = {"registers": [1] * 6, "dev_id": UNIT, "transaction_id": 7} | wrong
    here = wire()
    data = BUILD(ReadWriteMultipleRegistersResponse(**about)) + BUILD(ANSWER)  # type: ignore[arg-type]
    assert here.take(data, REQUEST) == list(ANSWER.registers)
    assert here.rejected == 1


@pytest.mark.parametrize("at", [8, 5])
def test_a_wrong_byte_count_is_counted(at: int) -> None:
    data, here = bytearray(BUILD(ANSWER)), wire()
    data[at] -= 2  # the count itself, or the length that the header says
    assert here.take(bytes(data), REQUEST) is None
    assert here.rejected == 1


@pytest.mark.parametrize(
    "head", [b"HTTP/1.1 400 Bad", b"\x00\x07\x00\x00\x00\x01\x01\x17", b"\x00\x07\x00\x00\xff\xff\x01"]
)
def test_what_is_no_modbus_ends_the_connection(head: bytes) -> None:
    here = wire()
    with pytest.raises(DeviceError, match="speaks no Modbus"):
        here.take(head, REQUEST)
    assert here.rejected == 1


def test_an_exception_is_said_in_words() -> None:
    with pytest.raises(Refused, match=r"has no such register \(code 2\)") as refused:
        wire().take(BUILD(ExceptionResponse(23, 2, UNIT, 7)), REQUEST)
    assert refused.value.code == 2


def test_hostile_frames_crash_nothing_and_each_is_counted() -> None:
    """100 000 mutated and random answers: each is an answer of the right length, or counted, or waits for more."""
    rng, rejected, waiting, refused, taken = random.Random(20), 0, 0, 0, 0
    right = [(request, BUILD(answer)) for request, answer in EXCHANGES]
    right.append((REQUEST, BUILD(ExceptionResponse(23, 2, UNIT, 7))))
    here = wire()
    for i in range(ROUNDS):
        request, data = right[i % len(right)]
        here.rejected = 0
        here._buffer.clear()
        try:
            found = here.take(mutated(rng, data), request)
        except Refused:
            refused += 1
            continue
        except DeviceError:
            assert here.rejected > 0
            rejected += 1
            continue
        if found is not None:
            wanted = {3: 3, 16: 0, 23: 6}[request.function_code]
            assert len(found) == wanted and all(0 <= word <= 0xFFFF for word in found)
            taken += 1
        elif here.rejected:
            rejected += 1
        else:
            assert len(here._buffer) < 7 + 254  # a beginning that may still become a frame
            waiting += 1
    assert rejected + waiting + refused + taken == ROUNDS
    assert min(rejected, waiting, refused, taken) > 100


def mutated(rng: random.Random, data: bytes) -> bytes:
    kind = rng.randrange(6)
    if kind == 0:
        return rng.randbytes(rng.randrange(0, 300))
    out = bytearray(data)
    if kind == 1:
        return bytes(out[: rng.randrange(len(out))])
    for _ in range(rng.randrange(1, 4)):
        at = rng.randrange(len(out))
        if kind == 2:
            out[at] ^= 1 << rng.randrange(8)
        elif kind == 3:
            out[at] = rng.randrange(256)
        elif kind == 4:
            out.insert(at, rng.randrange(256))
        else:
            out += data[:at]
    return bytes(out)


def test_frames_are_cut_one_after_the_other() -> None:
    buffer = bytearray(BUILD(ANSWER) + BUILD(ANSWER)[:5])
    first = take_frame(buffer)
    assert first is not None and (first.transaction, first.unit, first.body[0]) == (7, UNIT, 23)
    assert take_frame(buffer) is None and len(buffer) == 5


def test_registers_are_asked_for_in_few_runs() -> None:
    words = [(4, 1), (1, 1), (2, 1), (9, 1)]
    assert spans(words) == [(1, 2), (4, 1), (9, 1)]
    assert spans(words, gap=5) == [(1, 9)]
    assert spans((register, 1) for register in range(130)) == [(0, 120), (120, 10)]


def test_no_number_of_two_registers_is_parted_between_requests() -> None:
    assert spans([(0, 1), *((register, 2) for register in range(1, 131, 2))]) == [(0, 119), (119, 12)]
    assert spans([(10, 2), (11, 2)]) == [(10, 3)]


@pytest.mark.parametrize("kind", ["int16", "int32", "float32"])
@pytest.mark.parametrize("signed", [True, False])
@pytest.mark.parametrize("order", [(False, False), (True, False), (False, True), (True, True)])
def test_a_number_comes_back_from_its_registers_and_one_beyond_them_is_their_end(
    kind: Kind, signed: bool, order: tuple[bool, bool]
) -> None:
    coding = Coding(kind, signed, *order)
    least, most = coding.range
    for value in (0.0, 1.0, 258.0, 30000.0, *((-1.0, -12345.0) if least < 0 else ())):
        words = coding.words(value)
        assert len(words) == coding.width and all(0 <= word <= 0xFFFF for word in words)
        assert coding.value(words) == value
    assert coding.value(coding.words(1e39)) == pytest.approx(most)
    assert coding.value(coding.words(-1e39)) == pytest.approx(least)


def test_a_float_that_is_no_number_is_none() -> None:
    assert math.isnan(Coding("float32", True, False, False).value([0x7FC0, 0]))
