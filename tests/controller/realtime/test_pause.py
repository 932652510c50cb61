"""The twin's time stands still and goes on by steps, in a real rig process behind the real link."""

import time
from collections.abc import Iterator

import numpy as np
import pytest

from controller.errors import ParameterError, RigUnreachable
from controller.link.client import GONE_S
from controller.realtime.pause import UNHEARD_S
from controller.schema.messages import TwinTime
from controller.schema.modes import Cause, Mode, Request
from tests.controller.live_rig import LiveRig, Operator, live_rig, wait_for

pytestmark = pytest.mark.alone

PAUSED = TwinTime(paused=True)


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveRig]:
    with live_rig(tmp_path_factory.mktemp("rig")) as rig:
        yield rig


@pytest.fixture
def rig(shared: LiveRig) -> Iterator[LiveRig]:
    """In FOLLOW, on its way."""
    operator = shared.operator
    wait_for(lambda: answers(operator))
    operator.arm_and_follow()
    head = shared.ring().head
    wait_for(lambda: shared.ring().head > head + 150)
    operator.send()
    yield shared
    operator.client.time(TwinTime())
    operator.send(Request.REST)
    wait_for(lambda: operator.newest()["mode"] == Mode.VENTED)


def answers(operator: Operator) -> bool:
    """Whether the rig does, in time: on a machine that is busy it may not."""
    try:
        return operator.send().accepted
    except RigUnreachable:
        return False


def pause(rig: LiveRig, seconds: float = 0.0) -> int:
    """Pause, command on for `seconds`, and give the number of rows there are then."""
    assert rig.operator.client.time(PAUSED) == PAUSED
    wait_for(lambda: rig.operator.client.paused)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        assert rig.operator.send().accepted
        time.sleep(0.05)
    return rig.ring().head


def test_paused_no_tick_is_taken_and_the_rig_stays_connected(rig: LiveRig) -> None:
    head = pause(rig)
    assert pause(rig, 1.5 * GONE_S) == head
    assert rig.operator.client.connected
    assert rig.operator.client.age() < 0.5


def test_after_a_pause_all_goes_on_as_if_no_time_had_passed(rig: LiveRig) -> None:
    limits = rig.settings.parameters.limits
    head = pause(rig, 2 * max(limits.operator_timeout, limits.server_hold, limits.loop_gap))
    rig.operator.client.time(TwinTime())
    wait_for(lambda: rig.ring().head > head + 100)
    rows = rig.ring().read(head - 100, 200)[1]
    assert np.all(rows["mode"] == Mode.FOLLOW)
    assert np.all(np.diff(rows["tick"]) == 1)
    assert rows["slot"][-1] - rows["slot"][0] == rows["tick"][-1] - rows["tick"][0] + rows["lost"][-1] - rows["lost"][0]
    assert np.all(np.linalg.norm(np.diff(rows["p_ref"], axis=0), axis=1) < 1e-3)
    assert rows["measurement_age"].max() < 0.1
    assert rows["operator_age"].max() < limits.operator_timeout


def test_steps_are_taken_by_number_and_end_in_the_same_pause(rig: LiveRig) -> None:
    head = pause(rig)
    for steps in (1, 7, 250):
        left = rig.operator.client.time(TwinTime(paused=True, steps=steps)).steps
        assert left <= steps
        wait_for(lambda: rig.operator.client.time().steps == 0)
        time.sleep(0.05)
        head += steps
        assert rig.ring().head == head
    wait_for(lambda: rig.operator.newest()["tick"] == rig.ring().newest()["tick"])  # type: ignore[index]
    wait_for(lambda: rig.operator.client.paused)


def test_what_stills_the_rig_ends_the_pause_and_is_obeyed_at_once(rig: LiveRig) -> None:
    for request, mode in ((Request.HOLD, Mode.HOLD), (Request.E_STOP, Mode.E_STOP)):
        pause(rig)
        reply = rig.operator.send(request)
        assert (reply.accepted, reply.mode) == (True, mode)
        assert not rig.operator.client.time().paused
    assert rig.operator.send(Request.CLEAR).accepted


def test_nothing_is_begun_while_paused_and_the_target_waits_for_the_next_tick(rig: LiveRig) -> None:
    pause(rig)
    reply = rig.operator.send(Request.TRACK)
    assert not reply.accepted
    assert reply.detail == "refused: TRACK is not possible while the twin is paused; continue it first"
    assert rig.operator.send(target=(0.2, 0.1)).accepted
    rig.operator.client.time(TwinTime(paused=True, steps=1))
    wait_for(lambda: tuple(rig.operator.newest()["target"]) == (0.2, 0.1))


def test_a_twin_that_no_server_commands_goes_on_and_its_watchdogs_still_it(rig: LiveRig) -> None:
    head = pause(rig)
    time.sleep(UNHEARD_S / 2)
    assert rig.ring().head == head
    wait_for(lambda: rig.operator.newest()["mode"] != Mode.FOLLOW)
    assert rig.operator.newest()["cause"] in (Cause.OPERATOR_LOST, Cause.SERVER_LOST)


@pytest.mark.parametrize(
    ("wanted", "text"),
    [
        (TwinTime(paused=False, steps=3), "steps = 3 are taken only while the twin is paused"),
        (TwinTime.model_construct(paused=True, steps=10_001), "steps = 10001"),
    ],
)
def test_steps_that_mean_nothing_are_refused_with_value_and_bound(rig: LiveRig, wanted: TwinTime, text: str) -> None:
    with pytest.raises(ParameterError, match=text):
        rig.operator.client.time(wanted)
