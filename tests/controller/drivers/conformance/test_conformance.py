import re
import threading
import time
from typing import Any, ClassVar

import numpy as np
import pytest
from pydantic import Field as Bounds

from controller.drivers.conformance import Row, check_driver
from controller.drivers.conformance.bench import RADIUS
from controller.drivers.conformance.suite import CAPTURE, FIRST, LAST, VALVES
from controller.drivers.device import CaptureDevice, DeviceError, Outlet, Reading, Sample
from controller.errors import ParameterError
from controller.schema.hardware import CHANNELS
from controller.schema.layout import Model
from controller.virtual.bench import PeerBench
from controller.virtual.firmware import compiler
from controller.virtual.peers import Drive
from controller.virtual.registry import CAPTURE_PEERS, VALVE_PEERS
from tests.controller.drivers.conformance.in_memory import BenchInMemory, Good, GoodOptions

pytestmark = [pytest.mark.alone, pytest.mark.keyed()]


class BlocksForever(Good):
    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        if not self.bench.up:
            threading.Event().wait()
        return super().exchange(outlet, timeout)


class TakesItsTime(Good):
    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        time.sleep(timeout + 0.2)
        return super().exchange(outlet, timeout)


class SeesTheFuture(Good):
    def reading(self) -> Reading:
        return super().reading()._replace(t_ns=time.monotonic_ns() + 1_000_000_000)


class StampsByTheWall(Good):
    def reading(self) -> Reading:
        return super().reading()._replace(t_ns=time.time_ns())


class ShowsThePast(Good):
    first: ClassVar[int] = 0

    def reading(self) -> Reading:
        type(self).first = self.first or time.monotonic_ns()
        return super().reading()._replace(t_ns=self.first)


class SpeaksPsi(Good):
    def reading(self) -> Reading:
        found = super().reading()
        return found._replace(pressures=found.pressures / 6894.757)


class ForgetsTheChambers(Good):
    def reading(self) -> Reading:
        return super().reading()._replace(pressures=self.bench.chambers.pressures()[:4])


class SaysInfinity(Good):
    def reading(self) -> Reading:
        return super().reading()._replace(pressures=np.array([np.inf, 0.0, 0.0, 0.0]))


class RaisesValueError(Good):
    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        if not self.bench.up:
            raise ValueError("invalid literal for int()")
        return super().exchange(outlet, timeout)


class NeverVents(Good):
    def send(self, outlet: Outlet) -> None:
        super().send(outlet._replace(vent=False, cut=False))


class SendsAnything(Good):
    def send(self, outlet: Outlet) -> None:
        super().send(outlet)
        wanted = np.zeros(CHANNELS)
        wanted[list(self.chambers)] = 0.0 if outlet.vent else outlet.pressures
        self.bench.tell(wanted, outlet.vent)


class LeaksAThread(Good):
    def open(self) -> None:
        super().open()
        threading.Thread(target=threading.Event().wait, args=(8.0,), name="leak", daemon=True).start()


class OpensOnlyOnce(Good):
    opened = False

    def open(self) -> None:
        if self.opened:
            raise DeviceError("address in use")
        self.opened = True
        super().open()


class WaitsOnWhenClosed(Good):
    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        if not self.bench.speaks:
            time.sleep(timeout)
            return None
        return super().exchange(outlet, timeout)


class WaitsOnBehindALateFrame(WaitsOnWhenClosed):
    late = True

    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        if not self.bench.speaks and self.late:
            self.late = False
            return self.reading()
        return super().exchange(outlet, timeout)


class LooseOptions(Model):
    port: int = 4000


class HasNoBounds(Good):
    Options: Any = LooseOptions


class ListOptions(Model):
    registers: list[int] = Bounds(default=[1, 2])


class HasNoBoundsInItsList(Good):
    Options: Any = ListOptions


class PerhapsOptions(Model):
    port: int | None = None


class HasNoBoundsWhereItMayBeNone(Good):
    Options: Any = PerhapsOptions


class SpeaksPsiBothWays(SpeaksPsi):
    """Its sensors agree with its setpoints."""

    def send(self, outlet: Outlet) -> None:
        super().send(outlet._replace(pressures=outlet.pressures * 6.894757))

    def reading(self) -> Reading:
        found = Good.reading(self)
        return found._replace(pressures=found.pressures / 6.894757)


class DrivesNothing(Good):
    def send(self, outlet: Outlet) -> None:
        super().send(Outlet.vented())


BAD: list[tuple[type[Good], str, str]] = [
    (BlocksForever, "survives a loss", "exchange did not return within"),
    (TakesItsTime, "keeps to its time", r"exchange took 0\.\d+ s at a timeout of 0.1 s"),
    (SeesTheFuture, "frames are fresh", "in the future of our monotonic clock"),
    (StampsByTheWall, "frames are fresh", "in the future of our monotonic clock"),
    (ShowsThePast, "frames are fresh", "only 1 have a time of their own"),
    (SpeaksPsi, "follows setpoints", "other units, or other chambers"),
    (ForgetsTheChambers, "follows setpoints", "other units, or other chambers"),
    (SaysInfinity, "frames are well formed", "a pressure is infinite"),
    (RaisesValueError, "survives a loss", "raised ValueError: invalid literal"),
    (NeverVents, "vents when told", "a vented command is not obeyed within 0.5 s"),
    (SendsAnything, "sends nothing impossible", "a command of nan leaves as it is"),
    (LeaksAThread, "opens and closes twice", "it leaves a thread behind: leak, leak"),
    (OpensOnlyOnce, "opens and closes twice", "raised DeviceError: address in use"),
    (WaitsOnWhenClosed, "ends when closed", "a call that waits is not ended by close"),
    (WaitsOnBehindALateFrame, "ends when closed", "a call that waits is not ended by close"),
    (HasNoBoundsInItsList, "options have bounds", "options.registers has no minimum"),
    (HasNoBoundsWhereItMayBeNone, "options have bounds", "options.port has no minimum"),
    (SpeaksPsiBothWays, "speaks pascal", "the valves are told .* other units, or other chambers"),
    (DrivesNothing, "vents when told", "the sensors say"),
    (DrivesNothing, "vents when the host dies", "the sensors say"),
    (HasNoBounds, "options have bounds", "options.port has no minimum"),
]


@pytest.fixture
def bench() -> BenchInMemory:
    Good.bench = BenchInMemory()
    return Good.bench


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is in memory answers at once: a hundred milliseconds tell what three seconds do."""
    monkeypatch.setattr("controller.drivers.conformance.valves.SETTLE", 0.4)
    monkeypatch.setattr("controller.drivers.conformance.trial.HANGS", 0.3)
    monkeypatch.setattr("controller.drivers.conformance.frames.SPAN", 0.2)


def failed(rows: list[Row]) -> list[Row]:
    return [row for row in rows if row.answer != "shown"]


def test_a_good_driver_passes_every_check(bench: BenchInMemory) -> None:
    rows = check_driver(Good, {}, bench)
    assert failed(rows) == []
    assert [row.check for row in rows] == [*FIRST, *VALVES, *LAST]


@pytest.mark.parametrize(("kind", "check", "text"), BAD, ids=[f"{kind.__name__}-{check}" for kind, check, _ in BAD])
def test_each_bad_driver_fails_the_check_that_is_meant_for_it(
    bench: BenchInMemory, kind: type[Good], check: str, text: str
) -> None:
    (row,) = check_driver(kind, {}, bench, only=[check])
    assert row.answer == "failed"
    assert re.search(text, row.detail), row.detail


def test_a_device_that_goes_on_without_its_host_fails(bench: BenchInMemory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.controller.drivers.conformance.in_memory.WATCHDOG_S", 60.0)
    monkeypatch.setattr("controller.drivers.conformance.watchdog.LOST_LIMIT", 0.4)
    (row,) = check_driver(Good, {}, bench, only=["vents when the host dies"])
    assert row.answer == "failed" and "the valves go on for more than 0.4 s" in row.detail


def test_without_a_bench_nothing_is_commanded_and_the_rows_say_so(bench: BenchInMemory) -> None:
    told: list[Drive] = []
    bench.chambers.take = lambda drive: told.append(drive)  # type: ignore[method-assign]
    rows = {row.check: row for row in check_driver(Good)}
    unseen = {name for name, row in rows.items() if row.answer == "not shown"}
    assert unseen == {*VALVES, "ends when closed", "survives a loss"}
    assert all("what would show it: " in rows[name].detail for name in unseen)
    assert not any(row.answer == "failed" for row in rows.values())
    assert told and all(drive.vent for drive in told)


class NestedOptions(Model):
    inner: GoodOptions = GoodOptions()


class HasNestedOptions(Good):
    Options: Any = NestedOptions


def test_options_that_cannot_be_tried_are_not_said_to_have_bounds(bench: BenchInMemory) -> None:
    (row,) = check_driver(HasNestedOptions, {}, bench, only=["options have bounds"])
    assert row.answer == "not shown" and "options.inner is no number" in row.detail


def test_of_a_bench_that_does_not_say_what_it_was_told_nothing_is_said(
    bench: BenchInMemory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench, "driven", lambda: None)
    for check in ("speaks pascal", "sends nothing impossible"):
        (row,) = check_driver(Good, {}, bench, only=[check])
        assert row.answer == "not shown", row


class Camera(CaptureDevice[GoodOptions]):
    """Sees one marker that goes round."""

    Options = GoodOptions
    bench: ClassVar[BenchInMemory]
    scale, hole, labels = 1.0, False, ("tip",)

    @property
    def name(self) -> str:
        return "camera"

    def open(self) -> None:
        if not self.bench.up:
            raise DeviceError("unplugged")

    def close(self) -> None:
        pass

    def read(self, timeout: float) -> Sample | None:
        time.sleep(0.001)
        if not (self.bench.up and self.bench.speaks):
            return None
        point = np.array([[0.0, RADIUS * self.scale, np.nan if self.hole else 0.0]])
        return Sample(time.monotonic_ns(), point, self.labels)


class InMillimetres(Camera):
    scale = 1000.0


class InFeet(Camera):
    scale = 3.28


class PartlySeen(Camera):
    hole = True


class NamesTooMany(Camera):
    labels = ("tip", "mid")


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (InMillimetres, "are these metres|more than 100 m away"),
        (InFeet, "are these metres"),
        (PartlySeen, "neither wholly numbers nor wholly nan"),
        (NamesTooMany, "2 labels for 1 points"),
    ],
)
def test_each_bad_camera_fails(bench: BenchInMemory, kind: type[Camera], text: str) -> None:
    Camera.bench = bench
    rows = failed(check_driver(kind, {}, bench, only=["shows metres", "frames are well formed"]))
    assert rows and any(re.search(text, row.detail) for row in rows)


class SeesNothing(Camera):
    def read(self, timeout: float) -> Sample | None:
        found = super().read(timeout)
        return found and found._replace(points=np.full((1, 3), np.nan))


def test_a_camera_that_sees_no_marker_is_not_said_to_show_metres(bench: BenchInMemory) -> None:
    Camera.bench = bench
    rows = check_driver(SeesNothing, {}, bench, only=["shows metres", "frames are well formed"])
    assert [row.answer for row in rows] == ["not shown", "not shown"]
    (row,) = check_driver(Camera, {}, only=["shows metres"])
    assert row.answer == "not shown" and "your ruler" in row.detail


def test_a_good_camera_passes_every_check(bench: BenchInMemory) -> None:
    Camera.bench = bench
    rows = check_driver(Camera, {}, bench)
    assert failed(rows) == []
    assert [row.check for row in rows] == [*FIRST, *CAPTURE, *LAST]


@pytest.mark.parametrize("driver", [*CAPTURE_PEERS, *VALVE_PEERS])
def test_our_drivers_pass_every_check_against_their_peers(driver: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("controller.drivers.conformance.trial.MARGIN", 1.0)  # other tests run beside this one
    if driver == "serial" and compiler() is None:
        pytest.skip("there is no C++ compiler")
    bench = PeerBench(driver)
    try:
        assert failed(check_driver(driver, {}, bench)) == []
    finally:
        bench.close()


def test_options_that_the_driver_does_not_take_are_refused_at_once(bench: BenchInMemory) -> None:
    with pytest.raises(ParameterError, match=r"driver.options.port = 0: .*greater than or equal to 1"):
        check_driver(Good, {"port": 0}, bench)
