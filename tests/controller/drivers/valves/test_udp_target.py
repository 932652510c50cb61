import random
import socket
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from controller.drivers.device import DeviceError
from controller.drivers.valves.udp_layout import VENT, Command, pack_command, pack_reply, unpack_command
from controller.drivers.valves.udp_target import UdpTarget
from controller.errors import ParameterError
from controller.virtual import udp_target
from controller.virtual.udp_target import OFFSET_NS, PRESSURE_MAX, WATCHDOG_S, UdpTargetPeer
from tests.controller.drivers.commands import ANSWER_S, SETPOINTS, Plant, vented, wanted
from tests.controller.drivers.effort import Waits
from tests.controller.drivers.valves.clock import Clock
from tests.controller.drivers.valves.test_udp_layout import REPLY_SENT, mutated
from tests.waiting import wait_for

ROUNDS = 100_000


@pytest.fixture
def plant() -> Plant:
    return Plant()


@pytest.fixture
def peer(plant: Plant) -> Iterator[UdpTargetPeer]:
    peer = UdpTargetPeer(plant.read, plant.take)
    peer.plug()
    yield peer
    peer.unplug()


@pytest.fixture
def target(peer: UdpTargetPeer) -> Iterator[UdpTarget]:
    target = target_at(peer)
    target.open()
    yield target
    target.close()


def target_at(peer: UdpTargetPeer, chambers: tuple[int, ...] = (0, 1, 2, 3), raw: bool = False) -> UdpTarget:
    return UdpTarget(UdpTarget.Options.model_validate(peer.options), chambers, raw)


def test_each_chamber_has_its_own_channel(peer: UdpTargetPeer, plant: Plant) -> None:
    target = target_at(peer, (3, 1, 0, 2))
    target.open()
    reading = target.exchange(wanted(), ANSWER_S)
    target.close()
    assert reading is not None and reading.pressures.tolist() == [3e3, 1e3, 0.0, 2e3]
    assert plant.drive.pressures[[3, 1, 0, 2]].tolist() == SETPOINTS.tolist()
    assert not plant.drive.raw and not plant.drive.vent


def test_raw_valves_get_openings(peer: UdpTargetPeer, plant: Plant) -> None:
    target = target_at(peer, raw=True)
    target.open()
    target.exchange(wanted(openings=np.array([-1.0, 0.5, 7.0, 0.0])), ANSWER_S)
    target.close()
    assert plant.drive.raw and plant.drive.openings[:4].tolist() == [-1.0, 0.5, 1.0, 0.0]


def test_a_target_has_four_channels() -> None:
    with pytest.raises(ParameterError, match="a target has channels 0 to 3"):
        UdpTarget(UdpTarget.Options(), (0, 1, 2, 4), False)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_vents(target: UdpTarget, plant: Plant, value: float) -> None:
    target.exchange(wanted(), ANSWER_S)
    target.exchange(wanted(np.array([value, 1e5, 1e5, 1e5])), ANSWER_S)
    assert plant.drive.vent and not plant.drive.pressures.any()


@pytest.mark.parametrize("cut", [False, True])
def test_a_vented_command_vents_whatever_else_it_says(target: UdpTarget, plant: Plant, cut: bool) -> None:
    target.exchange(wanted(), ANSWER_S)
    target.exchange(vented(cut), ANSWER_S)
    assert plant.drive.vent and plant.drive.cut == cut and not plant.drive.pressures.any()


def test_times_come_to_our_clock(target: UdpTarget) -> None:
    """The target's clock is an hour ahead: known to half the quickest way there and back, which tells of load, too."""
    ways: list[int] = []

    def asked() -> tuple[int, int, int]:
        sent = time.monotonic_ns()
        reading = target.exchange(wanted(), ANSWER_S)
        arrived = time.monotonic_ns()
        ways.append(arrived - sent)
        assert reading is not None
        return sent, reading.t_ns, arrived

    def near() -> bool:
        asked()
        return abs(target.clock_offset * 1e9 + OFFSET_NS) <= min(ways) / 2 + 1000  # a float of an hour: 0.5 us

    wait_for(near, "the target's clock to half the quickest way")
    off_ns = min(ways)
    for _ in range(100):
        sent, read, arrived = asked()
        assert sent - off_ns < read <= arrived


def test_the_target_vents_100_ms_after_the_last_command_and_stays_vented(
    target: UdpTarget, plant: Plant, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = Clock(monkeypatch, udp_target)
    target.exchange(wanted(), ANSWER_S)
    clock.pass_by(WATCHDOG_S - 1e-6)
    assert not plant.drive.vent
    clock.pass_by(2e-6)
    assert plant.drive.vent
    reading = target.exchange(wanted(), ANSWER_S)
    assert reading is not None and reading.stopped == "the target's watchdog vented" and plant.drive.vent
    target.exchange(vented(), ANSWER_S)
    reading = target.exchange(wanted(), ANSWER_S)
    assert reading is not None and reading.stopped == "" and not plant.drive.vent


def test_the_target_vents_at_its_own_limit(target: UdpTarget, plant: Plant) -> None:
    plant.sensed[2] = PRESSURE_MAX + 1.0
    reading = target.exchange(wanted(), ANSWER_S)
    assert reading is not None and "own limit" in reading.stopped and plant.drive.vent


def test_losses_are_known_by_the_targets_count(peer: UdpTargetPeer, target: UdpTarget) -> None:
    first = target.exchange(wanted(), ANSWER_S)
    peer._number += 3
    second = target.exchange(wanted(), ANSWER_S)
    assert first is not None and second is not None and second.number - first.number == 4


def test_silence_is_none_in_time_and_a_late_answer_counts_for_its_own_command(
    peer: UdpTargetPeer, target: UdpTarget
) -> None:
    peer.freeze()
    waits = Waits(target._socket)
    target._socket = waits  # type: ignore[assignment]
    assert target.exchange(wanted(), 0.05) is None
    assert 0.0 < sum(waits.asked) <= 0.05
    peer.thaw()
    assert target.exchange(wanted(), ANSWER_S) is not None


def test_half_a_datagram_is_counted(peer: UdpTargetPeer, target: UdpTarget) -> None:
    peer.half_frame()
    assert target.exchange(wanted(), 0.05) is None and target.rejected == 1


def test_nobody_there_is_said_in_time() -> None:
    target = UdpTarget(UdpTarget.Options(host="127.0.0.1", port=1, connect_time=0.1), (0, 1, 2, 3), False)
    with pytest.raises((DeviceError, OSError)):
        target.open()
    target.close()


def test_a_target_that_was_away_begins_a_session_vented(peer: UdpTargetPeer, plant: Plant) -> None:
    target = target_at(peer)
    target.open()
    target.exchange(wanted(), ANSWER_S)
    peer.unplug()
    with pytest.raises(OSError):
        for _ in range(3):
            target.exchange(wanted(), 0.05)
    target.close()
    peer.plug()
    target.open()
    assert plant.drive.vent
    assert target.exchange(wanted(), ANSWER_S) is not None and not plant.drive.vent
    target.close()


def test_close_ends_a_call_that_waits(peer: UdpTargetPeer, target: UdpTarget) -> None:
    peer.freeze()
    errors: list[Exception] = []

    def wait() -> None:
        try:
            target.exchange(wanted(), 5.0)
        except (DeviceError, OSError) as error:
            errors.append(error)

    thread = threading.Thread(target=wait)
    thread.start()
    time.sleep(0.1)
    target.close()
    thread.join(60.0)
    assert not thread.is_alive() and len(errors) == 1


class Replies:
    """A target by hand: answers of our choice to a driver's commands."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(2.0)
        self.port = self.socket.getsockname()[1]
        self.sender = ("", 0)

    def heard(self) -> Command:
        data, self.sender = self.socket.recvfrom(200)
        command = unpack_command(data)
        assert command is not None
        return command

    def say(self, data: bytes) -> None:
        self.socket.sendto(data, self.sender)


@pytest.fixture
def opened() -> Iterator[tuple[UdpTarget, Replies]]:
    replies = Replies()
    target = UdpTarget(UdpTarget.Options(host="127.0.0.1", port=replies.port), (0, 1, 2, 3), False)

    def answer() -> None:
        replies.say(right(replies.heard()))

    first = threading.Thread(target=answer)
    first.start()
    target.open()
    first.join()
    yield target, replies
    target.close()
    replies.socket.close()


def right(command: Command) -> bytes:
    now = time.monotonic_ns()
    about = {"sequence": command.sequence, "session": command.session, "time": command.time}
    return pack_reply(REPLY_SENT._replace(flags=0, replied=now, read=now, **about))


def test_a_session_begins_with_a_vented_command(opened: tuple[UdpTarget, Replies]) -> None:
    target, replies = opened
    target.exchange(vented(), 0.001)
    command = replies.heard()
    assert command.flags & VENT and not any(command.pressures)


def test_answers_of_others_and_to_nothing_are_not_taken(opened: tuple[UdpTarget, Replies]) -> None:
    target, replies = opened
    target.exchange(wanted(), 0.001)
    command = replies.heard()
    wrong = [
        command._replace(sequence=command.sequence + 1),
        command._replace(session=command.session ^ 1),
        command._replace(time=command.time + 1),
    ]
    for one in wrong:
        replies.say(right(one))
    stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    stranger.sendto(right(command), replies.sender)
    stranger.close()
    replies.say(right(command))
    replies.say(right(command))  # once more: counted, too
    time.sleep(0.02)
    reading = target.exchange(wanted(), 0.02)
    assert reading is not None
    assert target.rejected == 4


def test_hostile_replies_move_no_clock_and_are_counted(opened: tuple[UdpTarget, Replies]) -> None:
    target, replies = opened
    rng, offset = random.Random(22), target.clock_offset
    for _ in range(500):
        target.exchange(wanted(), 0.0)
        data = right(replies.heard())
        other = mutated(rng, data)
        replies.say(other if other != data else b"")
    time.sleep(0.05)
    while target.exchange(wanted(), 0.01) is not None:
        pytest.fail("a mutated reply was taken")
    assert target.rejected == 500 and target.clock_offset == offset


def test_hostile_commands_move_nothing_and_each_is_counted(plant: Plant) -> None:
    """100 000 mutated and random datagrams at a target that drives: not one more command reaches its valves."""
    peer = UdpTargetPeer(plant.read, plant.take)
    sent = Command(VENT, 1, 7, 1, (0.0,) * 4, (0.0,) * 4)
    peer.take(pack_command(sent))
    sent = sent._replace(flags=0, sequence=2, pressures=(1e4, 2e4, 3e4, 4e4))
    assert peer.take(pack_command(sent)) is not None
    rng, driven = random.Random(23), len(plant.drives)
    data = pack_command(sent._replace(sequence=3))
    for _ in range(ROUNDS):
        other = mutated(rng, data)
        assert peer.take(other if other != data else data[1:]) is None
    assert peer.rejected == ROUNDS and len(plant.drives) == driven


def test_a_target_takes_no_old_command_and_no_session_that_begins_driving(plant: Plant) -> None:
    peer = UdpTargetPeer(plant.read, plant.take)
    sent = Command(VENT, 10, 7, 1, (0.0,) * 4, (0.0,) * 4)
    assert peer.take(pack_command(sent)) is not None
    for one in (sent, sent._replace(sequence=9), sent._replace(session=8, flags=0)):
        assert peer.take(pack_command(one)) is None
    assert peer.take(pack_command(sent._replace(sequence=11))) is not None
    assert peer.take(pack_command(sent._replace(sequence=1, session=8))) is not None
