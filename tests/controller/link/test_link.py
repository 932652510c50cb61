"""Both ends of the link over real zenoh, with a rig whose rows we make up: so batches can be lost at will."""

import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest
import zenoh

from controller.errors import LayoutMismatch, ParameterError, RigUnreachable
from controller.link import ENDLESS, PlannedRows, RigClient
from controller.link.asker import Asker
from controller.link.keys import Keys, open_session
from controller.schema.layout import to_record
from controller.schema.messages import Command
from tests.controller.fake_rig import KEY, FakeRig
from tests.controller.live_rig import wait_for

pytestmark = pytest.mark.alone


class Reader:
    """A client of the fake rig that notes ticks and boots."""

    def __init__(self, endpoint: str) -> None:
        self.ticks: list[int] = []
        self.boots: list[int] = []
        self.client = RigClient(endpoint, "fake", self.on_rows, lambda info: self.boots.append(info.boot), key=KEY)

    def on_rows(self, rows: np.ndarray) -> None:
        self.ticks.extend(rows["tick"].tolist())
        if len(self.ticks) == 10:
            raise RuntimeError("a reader's own mistake")


@pytest.fixture
def reader(endpoint: str, rig: FakeRig) -> Iterator[Reader]:
    reader = Reader(endpoint)
    meet(rig, reader)
    yield reader
    reader.client.close()


def meet(rig: FakeRig, reader: Reader) -> None:
    """Repeat the first rows until the connection is there; repeated rows are not delivered twice."""

    def met() -> bool:
        rig.publish(0, 5)
        return rig.boot in reader.boots and reader.client.connected

    wait_for(met)


def deliver(rig: FakeRig, reader: Reader, first: int, end: int) -> None:
    """Publish these rows until the reader has them all: a busy link may lose a batch, but a rig goes on publishing."""

    def has_all() -> bool:
        rig.publish(first, end)
        return reader.ticks[-1:] == [end - 1]

    wait_for(has_all)


def test_rows_of_a_lost_batch_are_fetched_again_and_delivered_in_order(rig: FakeRig, reader: Reader) -> None:
    rig.publish(5, 10)
    deliver(rig, reader, 20, 30)
    deliver(rig, reader, 9000, 9010)
    assert reader.ticks == list(range(9010))
    assert reader.client.gaps == 0
    assert rig.replays > 2


def test_a_rig_too_busy_to_answer_in_time_is_asked_again_and_nothing_is_lost(
    rig: FakeRig, reader: Reader, caplog: pytest.LogCaptureFixture
) -> None:
    deliver(rig, reader, 5, 10)
    wait_for(lambda: "own mistake" in caplog.text)  # logged after the reader has taken the rows
    caplog.clear()
    rig.busy = 0.7
    rig.publish(20, 30)
    deliver(rig, reader, 30, 40)
    assert reader.ticks == list(range(40))
    assert reader.client.gaps == 0
    assert rig.replays > 1
    assert "telemetry batch failed" not in caplog.text


def test_what_fails_in_a_batch_is_logged_with_one_traceback_for_each_kind(
    rig: FakeRig, reader: Reader, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(rows: np.ndarray) -> None:
        raise RuntimeError("a reader's own mistake")

    reader.client._stream._deliver = fail
    caplog.clear()
    firsts = iter(range(10, 10_000, 10))

    def complained() -> bool:
        first = next(firsts)
        rig.publish(first, first + 10)
        return len(caplog.records) >= 3

    wait_for(complained)
    assert all("RuntimeError: a reader's own mistake" in record.getMessage() for record in caplog.records)
    assert [bool(record.exc_info) for record in caplog.records[:3]] == [True, False, False]


def test_rows_that_the_ring_has_lost_are_skipped_and_counted(rig: FakeRig, reader: Reader) -> None:
    deliver(rig, reader, 5, 10)
    rig.kept = 15
    deliver(rig, reader, 20, 30)
    assert reader.ticks == [*range(10), *range(15, 30)]
    assert reader.client.gaps == 5


def test_a_slow_reader_does_not_hold_up_commands(rig: FakeRig, endpoint: str) -> None:
    go = threading.Event()
    client = RigClient(endpoint, "fake", lambda rows: (go.wait(), None)[1], key=KEY)
    wait_for(lambda: (rig.publish(0, 5), client.connected)[1])
    assert client.command(Command(n=3)).n == 3
    assert 0.0 < client.rtt() < 1.0
    go.set()
    client.close()


def test_a_restarted_rig_is_announced_and_its_rows_begin_at_tick_0(endpoint: str, rig: FakeRig, reader: Reader) -> None:
    deliver(rig, reader, 5, 10)
    rig.close()
    wait_for(lambda: not reader.client.connected)
    with pytest.raises(RigUnreachable, match="'fake'"):
        reader.client.command(Command())
    reader.ticks.clear()
    second = FakeRig(endpoint, boot=2)
    deliver(second, reader, 7, 9)
    assert reader.client.connected
    assert reader.boots == [1, 2]
    assert reader.ticks == list(range(9))
    assert reader.client.info is not None and reader.client.info.boot == 2
    second.close()


def test_a_rig_of_another_layout_is_refused_with_a_clear_word(endpoint: str) -> None:
    rig = FakeRig(endpoint, boot=1, layout="0123456789abcdef")
    reader = Reader(endpoint)
    wait_for(lambda: (rig.publish(0, 5), reader.client.refused)[1])
    assert not reader.client.connected
    with pytest.raises(LayoutMismatch, match=r"0123456789abcdef.*run the same version"):
        reader.client.command(Command())
    assert reader.ticks == reader.boots == []
    reader.client.close()
    rig.close()


def test_a_malformed_command_is_answered_with_field_value_and_bound(endpoint: str, rig: FakeRig) -> None:
    session = open_session(key=KEY, connect=endpoint)
    asker = Asker(session, Keys("fake"), KEY)

    def ask(payload: bytes) -> str:
        with pytest.raises(ParameterError) as refused:
            asker.ask_sealed(Keys("fake").command, payload)
        return str(refused.value)

    wait_for(lambda: list(session.get(Keys("fake").info)))

    raw = to_record(Command())
    assert ask(b"12345") == f"command of 5 bytes is not a Command record of {raw.itemsize} bytes"
    assert ask(b"").startswith("command of 0 bytes")
    broken = raw.copy()
    broken["target"][0, 1] = np.nan
    assert "target.1 = nan" in ask(broken.tobytes())
    broken = raw.copy()
    broken["settings"]["K_P"][0, 0] = 12.0
    assert ask(broken.tobytes()) == "settings.K_P.0 = 12.0: Input should be less than or equal to 5"
    broken = raw.copy()
    broken["request"] = 99
    assert "request = 99" in ask(broken.tobytes())
    session.close()


def test_a_replay_request_or_a_reference_of_wrong_size_is_refused(rig: FakeRig, reader: Reader) -> None:
    points, torques = np.random.default_rng(1).random((2, 7, 2))
    assert reader.client.plan(PlannedRows(points)) == 7
    assert np.array_equal(rig.planned.points, points)
    assert rig.planned[1:] == (None, None, 0, 7, None, None, False)
    kinds = np.arange(7) % 3
    assert reader.client.plan(PlannedRows(points, torques, kinds, 3, ENDLESS, steps=True)) == 7
    assert np.array_equal(rig.planned.points, points)
    assert rig.planned.torques == pytest.approx(torques, rel=1e-6)
    assert np.array_equal(rig.planned.kinds, kinds)
    assert rig.planned[3:] == (3, ENDLESS, None, None, True)
    assert reader.client.plan(PlannedRows(points, kinds=kinds)) == 7
    assert rig.planned.torques is None and np.array_equal(rig.planned.kinds, kinds)
    rows = PlannedRows(points, torques, kinds, 3, ENDLESS, torques + 1.0, torques[3:] + 2.0)
    assert reader.client.plan(rows) == 7
    assert rig.planned.planned == pytest.approx(torques + 1.0, rel=1e-6)
    assert rig.planned.planned_again == pytest.approx(torques[3:] + 2.0, rel=1e-6)
    assert rig.planned.torques == pytest.approx(torques, rel=1e-6) and np.array_equal(rig.planned.kinds, kinds)
    with pytest.raises(ParameterError, match="56 bytes is not four int64 words and rows of 16 bytes"):
        reader.client.plan(PlannedRows(np.zeros(3)))
    with pytest.raises(ParameterError, match="could not answer"):
        rig.rows = None  # type: ignore[assignment]
        reader.client.replay(0, 5)


def test_without_a_rig_everything_says_so_and_closing_ends_the_thread(endpoint: str) -> None:
    others = set(threading.enumerate())
    reader = Reader(endpoint)
    assert not reader.client.connected
    assert reader.client.info is None
    with pytest.raises(RigUnreachable, match="did not answer"):
        reader.client.command(Command())
    before = reader.client.age()
    time.sleep(0.01)
    assert reader.client.age() > before
    reader.client.close()
    reader.client.close()
    with pytest.raises(RigUnreachable):
        reader.client.command(Command())
    assert "rig-link" not in [thread.name for thread in set(threading.enumerate()) - others]


def test_a_batch_that_the_answer_overtook_is_passed_over_once(endpoint: str, rig: FakeRig) -> None:
    """The rig had sent it before it answered who it is, and it came after: on a busy machine, at every start."""
    reader, payload = Reader(endpoint), rig.rows[0:5].tobytes()
    told, overtaken = (rig.end._prover.batch(Keys("fake").telemetry, payload) for _ in range(2))
    wait_for(lambda: rig.end._publisher.matching_status.matching)
    rig.end._publisher.put(payload, attachment=told)
    wait_for(lambda: reader.client.info)
    rig.end._publisher.put(payload, attachment=overtaken)
    wait_for(lambda: (rig.publish(5, 10), reader.ticks[-1:] == [9])[1])
    assert reader.client._refusals.count == 0
    rig.end._publisher.put(payload, attachment=overtaken)
    wait_for(lambda: reader.client._refusals.count == 1)
    assert reader.ticks == [*range(5, 10)]
    reader.client.close()


def test_the_last_rows_of_a_rig_wait_where_the_link_is_full(rig: FakeRig, endpoint: str) -> None:
    """Any others are dropped there, and asked for again: a rig that has ended can be asked for none."""
    with open_session(key=KEY, connect=endpoint) as session:
        slow = session.declare_subscriber(Keys("fake").telemetry, zenoh.handlers.FifoChannel(1))

        def comes() -> bool:
            rig.publish(0, 1)
            return slow.try_recv() is not None

        wait_for(comes)
        for first in range(1, 2001):
            rig.publish(first, first + 50)
        last = threading.Thread(target=rig.end.publish_last, args=(rig.rows[-50:],))
        last.start()
        seen = [0]
        while seen[-1] != rig.rows["tick"][-1]:
            seen.append(int(np.frombuffer(slow.recv().payload.to_bytes(), rig.rows.dtype)["tick"][-1]))
        last.join()
        assert len(seen) < 2000, "nothing was dropped: the link was never full"
