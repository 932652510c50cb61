"""The supervisor with a real rig: killed, frozen, crashing at once, and stopped."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from controller.actuator import PRESETS
from controller.errors import TendrilError
from controller.modes import Cause, Mode, Request
from controller.realtime.ring import find_ring
from controller.realtime.settings import RigSettings
from controller.realtime.supervisor import Supervisor, restart_delay
from tests.controller.live_rig import Operator, wait_for


@pytest.fixture
def supervisor(tmp_path: Path) -> Iterator[Supervisor]:
    supervisor = Supervisor(RigSettings(rig="watched", folder=tmp_path, key_file=tmp_path / "watched.key"))
    supervisor.start()
    supervisor.wait_ready()
    yield supervisor
    supervisor.stop()


def connected_operator(supervisor: Supervisor) -> Operator:
    assert supervisor.settings.key_file
    operator = Operator(supervisor.endpoint, "watched", supervisor.settings.key_file)
    wait_for(lambda: operator.client.connected)
    return operator


def test_a_killed_rig_comes_back_vented_under_a_new_boot_id_and_needs_a_new_arm(
    supervisor: Supervisor, tmp_path: Path
) -> None:
    operator = connected_operator(supervisor)
    operator.arm_and_follow()
    old = operator.boots[0]
    os.kill(supervisor.process, signal.SIGKILL)
    wait_for(lambda: len(operator.boots) == 2)
    wait_for(lambda: operator.client.connected and operator.newest()["mode"] == Mode.VENTED)
    assert operator.boots[1] != old
    refused = operator.send(Request.ARM, boot=old)
    assert (refused.accepted, refused.mode, refused.cause) == (False, Mode.VENTED, Cause.WRONG_BOOT)
    assert operator.send(Request.ARM).mode == Mode.HOLD
    recorder = find_ring("watched", tmp_path).path.with_suffix(".last")
    assert recorder.exists()
    operator.client.close()


def test_a_rig_is_replaced_by_one_with_other_parameters_and_its_end_counts_as_no_failure(
    supervisor: Supervisor,
) -> None:
    operator = connected_operator(supervisor)
    parameters = supervisor.settings.parameters
    supervisor.replace(parameters.model_copy(update={"actuator": PRESETS["P2"]}))
    wait_for(lambda: len(operator.boots) == 2)
    info = operator.client.info
    assert info is not None
    assert info.parameters.actuator == PRESETS["P2"]
    assert supervisor.restarts == 0
    operator.client.close()


def test_a_frozen_rig_is_killed_and_started_again(supervisor: Supervisor) -> None:
    frozen = supervisor.process
    os.kill(frozen, signal.SIGSTOP)
    wait_for(lambda: supervisor.restarts == 1)
    operator = connected_operator(supervisor)
    assert supervisor.process != frozen
    assert operator.send(Request.ARM).accepted
    operator.client.close()


def test_stopping_ends_the_rig_vented(supervisor: Supervisor, tmp_path: Path) -> None:
    process = supervisor.process
    supervisor.stop()
    last = find_ring("watched", tmp_path).newest()
    assert last is not None and (last["mode"], last["cause"]) == (Mode.VENTED, Cause.OPERATOR)
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_a_rig_that_cannot_start_is_an_error_and_not_an_endless_wait(tmp_path: Path) -> None:
    supervisor = Supervisor(RigSettings(rig="watched", folder=tmp_path / "missing", key_file=tmp_path / "key"))
    supervisor.start()
    with pytest.raises(TendrilError, match="could not start"):
        supervisor.wait_ready()
    supervisor.stop()


def test_repeated_quick_deaths_slow_the_restarts_down() -> None:
    assert [restart_delay(deaths) for deaths in (0, 1, 2, 3, 4, 99)] == [0.0, 0.0, 0.5, 1.0, 2.0, 10.0]
