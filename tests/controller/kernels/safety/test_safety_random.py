"""Whatever is commanded and whatever fails, in any order: what must never happen does not happen in any tick.

TENDRIL_LONG=1 tries forty times as many worlds, other ones each time.
"""

import math
import os
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as some
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    precondition,
    rule,
    run_state_machine_as_test,
)

from controller.drivers.twin import inject
from controller.schema.layout import to_record
from controller.schema.messages import TwinFaults
from controller.schema.modes import Cause, Freeze, Law, Mode, Request
from controller.schema.parameters import ControllerParameters, RigParameters, Settings
from tests.controller.world import BOOT, LIMITS, World

pytestmark = pytest.mark.keyed()

LONG = os.environ.get("TENDRIL_LONG") == "1"
STOPPED, LATCHED, MOVING = (Mode.VENTED, Mode.E_STOP), (Mode.FAULT, Mode.E_STOP), (Mode.FOLLOW, Mode.TRACK)
BOUNDS, DT, EPS = ControllerParameters(), 1e-3, 1e-12
WAYS = {
    Mode.HOLD: [Request.ARM],
    Mode.FOLLOW: [Request.ARM, Request.FOLLOW],
    Mode.TRACK: [Request.ARM, Request.TRACK],
    Mode.REST: [Request.ARM, Request.FOLLOW, Request.REST],
    Mode.FAULT: [Request.ARM],
    Mode.E_STOP: [Request.E_STOP],
}

wild = some.sampled_from([math.nan, math.inf, -math.inf, 1e308, 2.0, -2.0])
coordinates = some.floats(-0.3, 0.3) | some.floats(-2.0, 2.0)
pairs = lambda top: some.tuples(some.floats(0.0, top), some.floats(0.0, top))  # noqa: E731
changes = some.fixed_dictionaries(
    {},
    optional={
        "law": some.sampled_from(Law),
        "sensed": some.sampled_from([0, 1 << 9, 1 << 5 | 1 << 9, 1023]),
        "K_P": pairs(5.0),
        "K_I": pairs(20.0),
        "K_FF": pairs(1.0),
        "K_o": pairs(500.0),
        "B_o": pairs(5.0),
        "feedforward_period": some.sampled_from([0.001, 0.01, 0.1]),
        "speed_max": some.floats(0.001, 1.0),
        "acceleration_max": some.floats(0.01, 10.0),
        "u_open": some.tuples(some.floats(-0.2, 0.2), some.floats(-0.2, 0.2)),
    },
)
faults = some.builds(
    TwinFaults,
    noise=some.sampled_from([0.0, 1e-3, 0.02]),
    sample_loss=some.sampled_from([0.0, 0.5, 1.0]),
    marker_loss=some.sampled_from([0.0, 0.5, 1.0]),
    jump=some.sampled_from([(0.0, 0.0), (0.05, 0.0), (0.0, -0.2)]),
    freeze=some.sampled_from(Freeze),
    sensors_stuck=some.sampled_from([0, 1, 15]),
    valves_stuck=some.sampled_from([0, 4, 15]),
    supply_lost=some.booleans(),
)
whiles = some.sampled_from([1, 10, 60, 510, 1100])
pressures = some.sampled_from([-1.0, 0.0, 200e3, 340.1e3, -21e3, math.nan, math.inf])


class AnythingGoes(RuleBasedStateMachine):
    """Random acts; between them the rig runs on, and every tick is judged."""

    start = Mode.VENTED

    def __init__(self) -> None:
        super().__init__()
        self.world = World()
        self.presence, self.presence_ns, self.acted_on = 1, int(self.world.now[0]), 0

    @initialize(goal=some.tuples(some.just(0.15), some.floats(-0.15, 0.15)))
    def begin(self, goal: tuple[float, float]) -> None:
        """In the mode `start`, with a reference planned."""
        self.plan(0.01, 3.0, 5000)
        self.world.command["target"] = goal
        for request in WAYS.get(self.start, []):
            self.request(request, BOOT, 1, 0)
            self.run(60)
        if self.start == Mode.FAULT:
            self.break_twin(TwinFaults(marker_loss=1.0), 700)
            self.break_twin(TwinFaults(), 1)
        assert self.world.rows[-1]["mode"] == self.start

    @rule(
        request=some.sampled_from([*Request, *Request, -1, 8]),
        boot=some.sampled_from([BOOT] * 5 + [BOOT - 1]),
        by=some.sampled_from([1] * 5 + [0, -1, 5]),
        unattended=some.sampled_from([0, 0, 0, 1]),
    )
    def request(self, request: int, boot: int, by: int, unattended: int) -> None:
        command = self.world.command
        command["request_n"] += by
        command["request"], command["boot"], command["unattended"] = request, boot, unattended
        self.run(1)

    @rule(x=coordinates, y=coordinates)
    def target(self, x: float, y: float) -> None:
        self.world.command["target"] = x, y

    @rule(x=wild, field=some.sampled_from(["target", "K_P", "K_o", "u_open"]))
    def wild_number(self, x: float, field: str) -> None:
        """What the border would refuse, for a tick."""
        command = self.world.command
        place = command if field == "target" else command["settings"]
        kept = place[field].copy()
        place[field] = x
        self.run(1)
        place[field] = kept

    @rule(changed=changes)
    def change(self, changed: dict[str, Any]) -> None:
        self.world.command["settings"] = to_record(Settings(**changed))

    @precondition(lambda self: self.world.rows[-1]["mode"] != Mode.TRACK)
    @rule(radius=some.floats(0.0, 0.2), turns=some.floats(0.1, 10.0), rows=some.integers(1, 3000))
    def plan(self, radius: float, turns: float, rows: int) -> None:
        angle = np.linspace(0.0, 2 * np.pi * turns, rows)
        control = self.world.rig.control
        control.reference[:rows] = np.column_stack([0.15 + radius * np.cos(angle), radius * np.sin(angle)])
        control.guide[:rows] = np.nan
        control.plan[0] = rows, 0, 2 * rows

    @rule(
        operator=some.booleans(), server=some.booleans(), pump=some.booleans(), repeat=some.integers(0, 3), ticks=whiles
    )
    def who_is_there(self, operator: bool, server: bool, pump: bool, repeat: int, ticks: int) -> None:
        switches, command = self.world.switches, self.world.command
        switches.operator[0], switches.server[0], switches.pump[0] = operator, server, pump
        command["presence"] -= 0 if operator else repeat  # another server repeats what it knows
        self.run(ticks)

    @rule(injected=faults, ticks=whiles)
    def break_twin(self, injected: TwinFaults, ticks: int) -> None:
        inject(injected, self.world.twin.faults)
        self.run(ticks)

    @rule(shown=some.tuples(pressures, pressures, pressures, pressures))
    def break_sensors(self, shown: tuple[float, ...]) -> None:
        self.world.switches.pressures[:] = shown

    @rule()
    def mend(self) -> None:
        """All is well again, and the way out is taken."""
        self.world.switches.pressures[:] = -1.0
        self.who_is_there(True, True, True, 0, 1)
        self.break_twin(TwinFaults(), 60)
        for request in (Request.CLEAR, Request.ARM, Request.FOLLOW):
            self.request(request, BOOT, 1, 0)
            self.run(20)

    @rule(milliseconds=some.sampled_from([2, 49, 51, 300, 5000]))
    def stall(self, milliseconds: int) -> None:
        self.world.stall(milliseconds)
        self.run(1)

    @rule(ticks=whiles)
    def run(self, ticks: int) -> None:
        command = self.world.command[0].copy()
        rows, states = self.world.run(ticks)
        self.judge_modes(rows, command)
        self.judge_operator(rows)
        judge_command(rows, self.world)
        judge_rates(rows, states, self.world.command["settings"][0])
        judge_reference(rows)

    def judge_modes(self, rows: Any, command: Any) -> None:
        """Only a new, legal request, meant for this boot, leads out of a latch, up from vented, or into motion."""
        mode, fresh = rows["mode"], command["request_n"] > self.acted_on
        assert (rows["request_n"][1:] == max(self.acted_on, command["request_n"])).all()
        self.acted_on = int(rows["request_n"][-1])
        for n in np.flatnonzero(np.diff(mode)) + 1:
            before, after = Mode(mode[n - 1]), Mode(mode[n])
            asked = Request(command["request"]) if n == 1 and fresh and 0 <= command["request"] <= 7 else Request.NONE
            if asked not in (Request.NONE, Request.E_STOP) and command["boot"] != BOOT:
                asked = Request.NONE
            if after == Mode.E_STOP:
                continue
            if before in LATCHED:
                assert (after, asked) == (Mode.VENTED, Request.CLEAR)
            if before == Mode.VENTED:
                assert asked == Request.ARM
                assert after == Mode.HOLD or (after == Mode.FAULT and rows["cause"][n] != Cause.OPERATOR)
            if after in MOVING:
                assert asked.name == after.name
            if rows["cause"][n] == Cause.OPERATOR:
                assert asked != Request.NONE

    def judge_operator(self, rows: Any) -> None:
        """What moves has an operator, whose counter rose above all that it ever was within the last half second."""
        rose = np.flatnonzero(np.diff(np.maximum.accumulate(np.append(self.presence, rows["presence"][1:])))) + 1
        self.presence = max(self.presence, int(rows["presence"].max()))
        seen_ns = np.zeros(len(rows), np.int64)
        seen_ns[0], seen_ns[rose] = self.presence_ns, rows["t_ns"][rose]
        seen_ns = np.maximum.accumulate(seen_ns)
        self.presence_ns = int(seen_ns[-1])
        attended = (rows["mode"] == Mode.FOLLOW) | (
            (rows["mode"] == Mode.TRACK) & (self.world.states["unattended"][-1] == 0)
        )
        attended[0] = False
        assert ((rows["t_ns"] - seen_ns)[attended] <= LIMITS.operator_timeout * 1e9).all()


def judge_command(rows: Any, world: World) -> None:
    """Finite, admissible, and nothing at all where the rig is vented."""
    u, p, polygon = rows["u"][1:], rows["pressure_cmd"][1:], world.rig.control.smap.polygon
    stopped = np.isin(rows["mode"][1:], STOPPED)
    assert np.isfinite(u).all() and np.isfinite(p).all()
    assert not u[stopped].any() and not p[stopped].any()
    assert ((u @ polygon.normals.T) <= polygon.bounds + 1e-9).all()
    assert (p >= 0.0).all() and (p <= RigParameters().actuator.pressure_max * (1 + 1e-9)).all()
    assert not (p[:, ::2] * p[:, 1::2]).any()


def judge_rates(rows: Any, states: Any, chosen: Any) -> None:
    """Torque and pressure, and in FOLLOW what leads the tip, change no faster than they may."""
    mode, change = rows["mode"][1:], np.abs(np.diff(rows["u"], axis=0)).max(axis=1)
    pressure = np.abs(np.diff(rows["pressure_cmd"], axis=0)).max(axis=1)
    most = np.full(len(mode), math.inf)  # a plan may step, and to be vented is a step
    most[np.isin(mode, [Mode.HOLD, Mode.FOLLOW])] = BOUNDS.torque_slew_max
    most[np.isin(mode, [Mode.REST, Mode.FAULT])] = BOUNDS.rest_rate
    open_loop = (mode == Mode.FOLLOW) & (rows["law"][1:] == Law.OPEN_LOOP)
    most[open_loop] = BOUNDS.torque_rate_max
    assert (change <= most * DT + EPS).all()
    assert (pressure <= most * DT * max(RigParameters().actuator.pressure_map) + 1e-6).all()
    steady = (rows["mode"][1:] == Mode.FOLLOW) & (rows["mode"][:-1] == Mode.FOLLOW) & (rows["law"][1:] != Law.OPEN_LOOP)
    steady &= (states["blending"][1:] == 0) & (states["blending"][:-1] == 0)
    velocity, speed = states["wish_dot"], np.linalg.norm(states["wish_dot"], axis=1)
    moved = np.linalg.norm(np.diff(states["wish"], axis=0), axis=1)[steady]
    assert (speed[1:][steady] <= np.maximum(chosen["speed_max"], speed[:-1][steady]) + EPS).all()
    assert (moved <= np.maximum(chosen["speed_max"], speed[:-1][steady]) * DT + EPS).all()
    turned = np.linalg.norm(np.diff(velocity, axis=0), axis=1)[steady]
    assert (turned <= states["acceleration"][1:][steady] * DT * (1 + 1e-9) + EPS).all()


def judge_reference(rows: Any) -> None:
    """The reference of a rig that is stopped or holds stays where it is, to the inverse's tolerance while it holds."""
    both = lambda modes: np.isin(rows["mode"][1:], modes) & np.isin(rows["mode"][:-1], modes)  # noqa: E731
    step = np.linalg.norm(np.diff(rows["p_ref"], axis=0), axis=1)
    assert not step[both(STOPPED)].any()
    holds = both([Mode.HOLD]) & (rows["law"][1:] == rows["law"][:-1])
    assert (step[holds] <= 2e-4).all()
    still = holds & (rows["law"][1:] == Law.OPEN_LOOP)
    assert not np.diff(rows["u"], axis=0)[still].any()


@pytest.mark.timeout(3600 if LONG else 120)
@pytest.mark.parametrize("mode", Mode, ids=lambda mode: mode.name)
def test_whatever_happens_the_rig_moves_only_as_it_may(mode: Mode) -> None:
    machine = type(f"From{mode.name}", (AnythingGoes,), {"start": mode})
    profile = settings(
        max_examples=500 if LONG else 12,
        stateful_step_count=30,
        deadline=None,
        derandomize=not LONG,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.explicit, Phase.generate] + ([Phase.shrink] if LONG else []),
    )
    run_state_machine_as_test(machine, settings=profile)
