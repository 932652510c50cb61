"""What the samples of the markers tell: motion, a camera that shows the past, and speed, however they come in."""

import numpy as np
import pytest

from controller.arrays import Array
from controller.drivers.twin import inject
from controller.kernels.observer.sensing import WHIP
from controller.schema.messages import TwinFaults
from controller.schema.modes import Cause, Freeze, Law, Mode, Request
from controller.schema.parameters import ControllerParameters, RigParameters
from tests.controller.desk import MS, Desk
from tests.controller.trial import Trial, line

pytestmark = pytest.mark.keyed()

ROD_6 = 5
SPEED = 0.5
"""Of the tip in `Swinging` at most [m/s]."""


class Swinging:
    """A desk whose arm swings beside it at 1 Hz, as a rod that turns about its base; samples come in when told so."""

    def __init__(self, dt: float = 1e-3) -> None:
        self.desk = Desk(RigParameters(controller=ControllerParameters(dt=dt)), law=Law.FF)
        self.desk.camera = False
        self.period_ns = round(dt * 1e9)
        for limit in ("residual_max", "error_max"):
            self.desk.rig.control.limits[limit] = 1.0
        self.speeds: list[float] = []
        """Highest speed of any marker after each tick [m/s]."""

    def seen_at(self, t: float) -> Array:
        """Markers (10,2) [m] at `t` [s]."""
        angle, far = SPEED / (2 * np.pi * 0.253) * np.sin(2 * np.pi * t), 0.0253 * np.arange(1, 11)
        return np.column_stack([far * np.cos(angle), far * np.sin(angle)])

    def tick(self, stamp_ns: int | None = None, captured_ns: int = 0) -> np.void:
        """One period later; with `stamp_ns` what was captured at `captured_ns` comes in, stamped so."""
        desk, later = self.desk, self.period_ns
        if stamp_ns is not None:
            desk.measurement["t_ns"], desk.measurement["markers"] = stamp_ns, self.seen_at(captured_ns * 1e-9)
        desk.now += later - MS  # `step` adds a millisecond of its own
        row = desk.step()
        self.speeds.append(float(np.hypot(*desk.rig.sensing.v.T).max()))
        return row

    def stream(self, seconds: float, period_ns: int) -> np.void:
        """Samples every so often, stamped at their capture, which is when they come in."""
        for _ in range(round(seconds * 1e9 / self.period_ns)):
            newest = self.desk.now // period_ns * period_ns
            row = self.tick(newest, newest)
        return row

    def burst(self, held_ns: int, period_ns: int, apart_ns: int) -> np.void:
        """Nothing for `held_ns`, then all that were captured meanwhile, `apart_ns` apart, stamped as they come in.

        It ends when what comes in is no older than that: the queue is empty.
        """
        first = self.desk.now // period_ns + 1
        for _ in range(held_ns // self.period_ns):
            self.tick()
        begin, newest = self.desk.now, -1
        while True:
            sent = first + (self.desk.now + self.period_ns - begin) // apart_ns
            captured = min(sent, (self.desk.now + self.period_ns) // period_ns) * period_ns
            arrived = max(captured, begin + (captured // period_ns - first) * apart_ns)
            row = self.tick(arrived, captured) if captured != newest else self.tick()
            newest = captured
            if arrived == captured:
                return row


@pytest.mark.parametrize("name", ["P1", "P3"])
def test_a_frozen_camera_is_noticed_though_a_marker_that_is_not_used_has_jumped(name: str) -> None:
    trial = Trial(name)
    trial.arm()
    trial.follow(0.12, 0.1, 1.5)
    jumped = {"jump": (0.0, 0.05), "rods": 1 << ROD_6}
    inject(TwinFaults(**jumped), trial.twin.faults)
    assert (trial.run(200)["mode"] == Mode.FOLLOW).all()
    inject(TwinFaults(**jumped, freeze=Freeze.FRESH_TIME), trial.twin.faults)
    rows = trial.drag(line((0.12, 0.1), (0.12, -0.1), 40), 4.0)
    first = np.flatnonzero(rows["mode"] != Mode.FOLLOW)
    assert first.size and rows["cause"][first[0]] == Cause.MEASUREMENT_FROZEN


def test_a_marker_has_moved_that_is_elsewhere_than_where_it_was_seen_last_used_or_not() -> None:
    desk = Desk(law=Law.FF)
    desk.into(Mode.HOLD)
    state = desk.rig.control.state[0]

    def moved(step: int = 1) -> bool:
        """Whether a sample of the next `step` ms tells of motion."""
        before = int(state["moved_ns"])
        desk.step(step)
        return int(state["moved_ns"]) != before

    assert moved()
    desk.still, desk.markers[ROD_6, 1] = True, 0.05
    assert moved() and desk.rig.sensing.dropped[0] == 1 << ROD_6
    assert not moved(20)
    desk.markers[ROD_6, 1] += 1e-9
    assert moved() and not moved(20)
    desk.markers[2] = np.nan
    assert not moved(20), "out of sight"
    desk.markers[2] = 3 * 0.0253, 0.0
    assert not moved(20), "where it was"
    desk.markers[2, 0] += 1e-9
    assert moved() and not moved(20)
    assert desk.mode == Mode.HOLD


@pytest.mark.parametrize(
    ("dt", "period", "held", "apart"),
    [
        (1e-3, 10 * MS, 100 * MS, MS // 5),
        (1e-3, 10 * MS, 100 * MS, MS // 50),
        (1e-3, 10 * MS, 200 * MS, MS // 2),
        (1e-3, 5 * MS, 100 * MS, MS // 5),
        (1e-4, 10 * MS, 200 * MS, MS // 5),
        (1e-4, MS, 100 * MS, MS // 50),
        (1e-2, 10 * MS, 200 * MS, MS // 5),
    ],
)
def test_samples_that_were_held_back_and_come_all_at_once_tell_no_speed(
    dt: float, period: int, held: int, apart: int
) -> None:
    arm = Swinging(dt)
    arm.stream(1.3, period)
    arm.desk.ask(Request.ARM)
    for phase in (0.13, 0.37, 0.5):
        arm.stream(0.1 + phase, period)
        arm.burst(held, period, apart)
        row = arm.stream(0.1, period)
        assert arm.desk.rig.sensing.fast[0] < WHIP, "nor does it open the check for jumps"
        assert row["sensed"] == 1 << 9 and row["mode"] == Mode.HOLD
    assert max(arm.speeds) < 1.5 * SPEED, "what is usual has come down a little in the burst"


def test_a_marker_that_jumps_while_samples_are_held_back_is_not_used() -> None:
    arm = Swinging()
    arm.stream(2.0, 10 * MS)
    arm.desk.ask(Request.ARM)
    arm.stream(0.5, 10 * MS)
    here = arm.seen_at
    arm.seen_at = lambda t: here(t) + np.array([0.0, 0.12])  # type: ignore[method-assign]
    arm.burst(100 * MS, 10 * MS, MS // 5)
    assert arm.stream(0.2, 10 * MS)["sensed"] == 0


@pytest.mark.parametrize("lost", [0.0, 0.3])
@pytest.mark.parametrize("period", [MS, 3 * MS, 10 * MS, 33 * MS])
def test_the_speed_of_regular_samples_is_the_difference_of_the_last_two_to_the_bit(period: int, lost: float) -> None:
    arm, random = Swinging(), np.random.default_rng(1)
    seen: list[tuple[int, Array]] = []
    for k in range(1, 400):
        stamp = arm.desk.now // period * period + period
        while arm.desk.now < stamp:
            arm.tick()
        if random.random() < lost:
            continue
        arm.tick(stamp, stamp)
        seen.append((stamp, arm.seen_at(stamp * 1e-9)))
        if len(seen) > 1:
            (t_0, p_0), (t_1, p_1) = seen[-2:]
            assert np.array_equal(arm.desk.rig.sensing.v, (p_1 - p_0) * (1e9 / (t_1 - t_0))), k
