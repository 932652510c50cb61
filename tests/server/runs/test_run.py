"""What a run makes of the rig's rows; a test writes the rows."""

import math
from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.arrays import Rows
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Mode, RowKind
from controller.schema.parameters import RigParameters, Settings
from server.runs.lap import Lap, Leg, Order
from server.runs.laps import allowed_by
from server.runs.phases import Event, Machine
from server.runs.run import About, Before, Run
from server.runs.tally import COURSE, PHASE_ROWS, ErrorCourse, Tally

LEAD, N = 50, 200
OFF = np.array([3e-3, 0.0])
ALLOWED = allowed_by(RigParameters(), Settings(), drawn=True)
PATH = np.column_stack([0.2 + 0.01 * np.sin(2.0 * np.pi * np.arange(N) / N), 0.01 * np.arange(N) / N])


class Track:
    """A run of that many laps of PATH, and the rows of a rig that follows it 3 mm off."""

    def __init__(self, laps: int | None = 2, frequency: tuple[float, float] | None = None) -> None:
        judged = np.zeros(N, bool)
        self.lap = Lap(
            "path", np.empty((0, 2)), PATH, 0, np.zeros((N, 2)), frequency, judged, ALLOWED, kind=RowKind.DRAWN
        )
        self.machine = Machine()
        self.machine.meet(Event.READY)
        order = Order(self.lap, laps, RigParameters(), Settings(), "frozen")
        self.run = Run(About(4, order, datetime.now(UTC)), self.leg(0), self.machine, Before())
        self.tick = 1000

    @property
    def phase(self) -> str:
        return self.machine.shown

    def pause(self) -> None:
        assert self.machine.meet(Event.PAUSE, "by ann")

    def leg(self, done: int) -> Leg:
        onward = np.roll(PATH, -done, axis=0)
        p = np.vstack([np.tile(onward[0], (LEAD, 1)), onward])
        return Leg(p, np.zeros_like(p), np.arange(len(p)) < LEAD, LEAD, done, 10**9, kind=RowKind.DRAWN)

    def rows(self, mode: Mode, count: int = 1, cause: Cause = Cause.OPERATOR) -> Rows:
        rows = np.zeros(count, record_dtype(Telemetry))
        rows["tick"] = rows["slot"] = self.tick + np.arange(count)
        rows["mode"], rows["cause"], rows["u_ff"] = mode, cause, 0.01
        self.tick += count
        return rows

    def follow(self, leg: Leg, first: int, count: int) -> Rows:
        rows = self.rows(Mode.TRACK, count)
        rows["p_ref"] = leg.at(np.arange(first, first + count))
        rows["p_meas"] = rows["p_ref"] + OFF
        return rows


def test_a_run_goes_through_approach_and_laps_to_its_end_however_its_rows_are_cut() -> None:
    track = Track()
    run, leg = track.run, track.leg(0)
    run.take(track.rows(Mode.HOLD, 7))
    assert (track.phase, run.state().error) == ("approach", None)
    run.take(track.follow(leg, 0, LEAD))
    assert (track.phase, run.state().progress, run.state().error_rms) == ("approach", 0.0, None)
    assert run.state().error == pytest.approx(3e-3)
    run.take(track.follow(leg, LEAD, 1))
    assert (track.phase, run.left.done, run.state().lap) == ("running", 1, 1)
    run.take(track.follow(leg, LEAD + 1, 299))
    assert (run.state().progress, run.state().lap) == (0.75, 2)
    last = track.follow(leg, LEAD + 300, 100)
    run.take(np.concatenate([last, track.rows(Mode.HOLD, 5, Cause.REFERENCE_DONE)]))
    state, result = run.state(), run.result()
    assert (state.state, state.progress, state.lap, state.reason) == ("done", 1.0, 2, "")
    assert (state.error, state.error_rms) == (None, pytest.approx(3e-3))
    assert (state.elapsed, state.duration) == (pytest.approx(0.45), pytest.approx(0.2))
    assert (result.laps, result.duration, result.on_time_share) == (2.0, pytest.approx(0.45), 1.0)
    assert result.rmse == result.max_error == pytest.approx(3e-3)


def test_a_paused_run_goes_on_where_it_was_and_the_way_back_is_not_judged() -> None:
    track = Track()
    run, leg = track.run, track.leg(0)
    run.take(track.follow(leg, 0, LEAD + 120))
    track.pause()
    run.take(np.concatenate([track.follow(leg, LEAD + 120, 10), track.rows(Mode.HOLD, 90)]))
    assert (track.phase, track.machine.reason, run.left.done) == ("paused", "by ann", 130)
    assert np.array_equal(run.left.u, [0.01, 0.01])
    run.take(track.rows(Mode.FOLLOW, 40))
    assert track.phase == "paused", "an operator may look around meanwhile"
    again = track.leg(130)
    assert track.machine.meet(Event.RESUME) and track.machine.meet(Event.READY)
    run.begin(again, Before(track.tick - 1))
    held, way_back = track.rows(Mode.HOLD, 3), track.follow(again, 0, LEAD)
    way_back["p_meas"] += 1.0
    run.take(np.concatenate([held, way_back]))
    assert (track.phase, run.left.done, run.state().progress) == ("approach", 130, 130 / 400)
    run.take(np.concatenate([track.follow(again, LEAD, 270), track.rows(Mode.HOLD, 1, Cause.REFERENCE_DONE)]))
    assert (track.phase, run.state().progress) == ("done", 1.0)
    assert run.result().max_error == pytest.approx(3e-3)
    assert run.result().on_time_share == 1.0, "the pause lost no ticks"


@pytest.mark.parametrize(
    ("mode", "cause", "phase", "reason"),
    [
        (Mode.HOLD, Cause.OPERATOR, "stopped", "the operator asked for HOLD"),
        (Mode.FOLLOW, Cause.OPERATOR, "stopped", "the operator asked for FOLLOW"),
        (Mode.REST, Cause.OPERATOR, "stopped", "the operator asked for REST"),
        (Mode.HOLD, Cause.OPERATOR_LOST, "broken off", "HOLD (operator lost)"),
        (Mode.HOLD, Cause.SERVER_LOST, "broken off", "HOLD (server lost)"),
        (Mode.FAULT, Cause.TRACKING_ERROR, "broken off", "FAULT (tracking error)"),
        (Mode.E_STOP, Cause.OPERATOR, "broken off", "E-STOP (operator)"),
    ],
)
def test_who_ended_a_run_is_told_from_the_first_row_after_it(mode: Mode, cause: Cause, phase: str, reason: str) -> None:
    track = Track(None)
    track.run.take(track.follow(track.leg(0), 0, LEAD + 3 * N))
    track.run.take(track.rows(mode, 2, cause))
    assert (track.phase, track.machine.reason) == (phase, reason)
    assert track.machine.ended and track.run.result().laps == 3.0


def test_what_was_asked_of_the_rig_does_not_hide_what_the_rig_did_by_itself() -> None:
    for mode, cause, phase in [
        (Mode.HOLD, Cause.OPERATOR, "paused"),
        (Mode.FAULT, Cause.TRACKING_ERROR, "broken off"),
        (Mode.HOLD, Cause.REFERENCE_DONE, "done"),
    ]:
        track = Track()
        track.run.take(track.follow(track.leg(0), 0, LEAD))
        track.pause()
        track.run.take(track.rows(mode, 2, cause))
        assert track.phase == phase


def test_a_paused_run_ends_when_the_rig_leaves_the_modes_it_could_go_on_from() -> None:
    track = Track()
    track.run.take(track.follow(track.leg(0), 0, LEAD + 9))
    track.pause()
    track.run.take(np.concatenate([track.rows(Mode.HOLD, 9), track.rows(Mode.E_STOP, 9)]))
    assert (track.phase, track.machine.reason) == ("broken off", "E-STOP (operator)")


def test_until_stopped_the_progress_is_that_of_the_lap() -> None:
    track = Track(None)
    track.run.take(track.follow(track.leg(0), 0, LEAD + 2 * N + 50))
    assert (track.run.state().lap, track.run.state().progress, track.run.state().laps) == (3, 0.25, None)


def circle(frequency: float, lag: float, count: int, dt: float = 1e-3) -> Rows:
    rows = np.zeros(count, record_dtype(Telemetry))
    angle = 2.0 * np.pi * frequency * dt * np.arange(count)
    rows["slot"] = np.arange(count)
    rows["p_meas"] = 0.02 * np.column_stack([np.cos(angle - lag), np.sin(angle - lag)])
    rows["p_ref"] = 0.02 * np.column_stack([np.cos(angle), np.sin(angle)])
    return rows


def test_the_phase_is_that_of_the_newest_ticks_and_lost_ticks_are_counted() -> None:
    tally = Tally((2.0, 2.0), 1e-3)
    rows = circle(2.0, 0.3, 3000)
    tally.add(rows[:1000])
    tally.add(rows[1000:1000])
    tally.add(rows[1250:])
    found = tally.figures()
    assert found.lag_deg_x is not None and found.lag_deg_x == pytest.approx(math.degrees(0.3), abs=0.5)
    assert found.on_time_share == 2750 / 3000
    for _ in range(3 * PHASE_ROWS // 3000):
        tally.add(rows)
    assert sum(len(part) for part in tally._wanted) < PHASE_ROWS + 3000


@pytest.mark.parametrize("dt", [1e-4, 5e-4, 2e-3, 1e-2])
def test_the_phase_is_that_of_the_rig_s_own_period(dt: float) -> None:
    """At 2 ms a circle of 1 Hz was taken for one of 0.5 Hz."""
    tally = Tally((1.0, 1.0), dt)
    tally.add(circle(1.0, 0.3, round(3.0 / dt), dt))
    found = tally.figures()
    assert (found.lag_deg_x, found.lag_deg_y) == (pytest.approx(math.degrees(0.3)), pytest.approx(math.degrees(0.3)))
    short = Tally((1.0, 1.0), dt)
    short.add(circle(1.0, 0.3, round(0.9 / dt), dt))
    assert short.figures().lag_deg_x is None, "less than one period"


def test_a_tick_without_its_marker_has_no_error_but_a_run_without_any_has_none_at_all() -> None:
    tally = Tally(None, 1e-3)
    rows = circle(1.0, 0.0, 1000)
    rows["p_meas"][::2] = np.nan
    rows["p_ref"] += 2.0 / 3.0 * OFF
    tally.add(rows)
    assert tally.rmse == pytest.approx(2e-3)
    assert tally.figures().lag_deg_x is None
    half, most = Tally((1.0, 1.0), 1e-3), Tally((1.0, 1.0), 1e-3)
    half.add(rows)
    assert half.figures().lag_deg_x is None
    rows = circle(1.0, 0.1, 1000)
    rows["p_meas"][400:450] = np.nan
    most.add(rows)
    assert most.figures().lag_deg_x == pytest.approx(math.degrees(0.1), abs=0.1)
    blind = Tally(None, 1e-3)
    assert blind.figures().rmse is blind.figures().saturated_share is blind.figures().on_time_share is None


@given(st.lists(st.integers(0, 900), max_size=12), st.integers(0, 2**32))
def test_a_runs_errors_are_the_largest_of_equal_parts_however_its_rows_came(batches: list[int], seed: int) -> None:
    course, every, random = ErrorCourse(), np.empty(0), np.random.default_rng(seed)
    for count in batches:
        errors = np.where(random.random(count) < 0.3, math.nan, random.random(count))
        course.add(errors)
        every = np.concatenate((every, errors))
    width = next(2**k for k in range(20) if len(every) < COURSE * 2**k)
    largest = [np.fmax.reduce(every[at : at + width]) for at in range(0, len(every), width)]
    assert course.parts() == [None if math.isnan(one) else round(float(one), 7) for one in largest]
