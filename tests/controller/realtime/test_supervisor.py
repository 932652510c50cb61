"""The supervisor with a real rig: killed, frozen, crashing at once, and stopped."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from controller.errors import StartRefused, TendrilError
from controller.realtime.ring import find_ring
from controller.realtime.settings import RigSettings
from controller.realtime.supervisor import Started, Supervisor
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import RigParameters
from tests.controller.live_rig import Operator, wait_for
from tests.controller.simulation.test_acceptance import TOPPLED

pytestmark = pytest.mark.alone


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


def toppled(parameters: RigParameters) -> RigParameters:
    """With an actuator that the twin cannot be built for; its check was passed by, as if it had been by mistake."""
    fields = PRESETS["P1"].model_dump() | TOPPLED | {"name": "toppled"}
    return parameters.model_copy(update={"actuator": Actuator.model_validate(fields)})


def test_a_rig_that_fails_to_start_goes_back_to_the_parameters_that_ticked_last(
    supervisor: Supervisor, caplog: pytest.LogCaptureFixture
) -> None:
    operator = connected_operator(supervisor)
    supervisor.replace(toppled(supervisor.settings.parameters))
    wait_for(lambda: len(operator.boots) == 2)
    info = operator.client.info
    assert info is not None and info.parameters.actuator == PRESETS["P1"]
    failed = supervisor.started()
    assert failed is not None and failed.parameters.actuator.name == "toppled"
    assert "the unactuated body has no stable rest" in failed.reason
    assert "actuator toppled did not start: gravity" in caplog.text and "P1 is in force again" in caplog.text
    supervisor.replace(supervisor.settings.parameters.model_copy(update={"actuator": PRESETS["P3"]}))
    wait_for(lambda: len(operator.boots) == 3)
    found: list[Started | None] = []
    wait_for(lambda: found.append(supervisor.started()) or found[-1] is not None)
    assert found[-1] is not None
    assert (found[-1].parameters.actuator, found[-1].reason) == (PRESETS["P3"], "")
    assert supervisor.restarts == 0
    operator.client.close()


def test_a_first_start_that_fails_falls_back_too(tmp_path: Path) -> None:
    settings = RigSettings(rig="watched", folder=tmp_path, key_file=tmp_path / "watched.key")
    supervisor = Supervisor(
        settings.model_copy(update={"parameters": toppled(RigParameters())}), fallback=RigParameters()
    )
    supervisor.start()
    supervisor.wait_ready()
    started = supervisor.started()
    assert started is not None and "no stable rest" in started.reason
    assert supervisor.settings.parameters == RigParameters()
    operator = connected_operator(supervisor)
    assert operator.send(Request.ARM).accepted
    operator.client.close()
    supervisor.stop()


def test_a_frozen_rig_is_killed_and_started_again(supervisor: Supervisor) -> None:
    frozen = supervisor.process
    os.kill(frozen, signal.SIGSTOP)
    wait_for(lambda: supervisor.restarts == 1)
    operator = connected_operator(supervisor)
    assert supervisor.process != frozen
    assert operator.send(Request.ARM).accepted
    operator.client.close()


def test_stopping_ends_the_rig_vented(supervisor: Supervisor, tmp_path: Path) -> None:
    process, ring = supervisor.process, find_ring("watched", tmp_path)
    supervisor.stop()
    assert not ring.path.exists(), "it goes with the rig, for all who have it not open"
    last = ring.newest()
    assert last is not None and (last["mode"], last["cause"]) == (Mode.VENTED, Cause.OPERATOR)
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_a_rig_that_cannot_start_is_an_error_and_not_an_endless_wait(tmp_path: Path) -> None:
    supervisor = Supervisor(RigSettings(rig="watched", folder=tmp_path / "missing", key_file=tmp_path / "key"))
    supervisor.start()
    with pytest.raises(TendrilError, match="could not start"):
        supervisor.wait_ready()
    supervisor.stop()


def test_a_start_that_the_rig_itself_refuses_is_said_once(supervisor: Supervisor, tmp_path: Path) -> None:
    """The rig says why, and would say it again at every try."""
    with (tmp_path / "second.log").open("wb+") as output:
        settings = RigSettings(rig="watched", folder=tmp_path, key_file=tmp_path / "watched.key")
        second = Supervisor(settings, output=output)
        second.start()
        with pytest.raises(StartRefused, match="its own output says why"):
            second.wait_ready()
        second.worker.stop(10.0)
        second.stop()
        output.seek(0)
        said = output.read().decode()
    assert said.count("already runs on this machine") == 1 and second.restarts == 0
    assert connected_operator(supervisor).newest()["mode"] == Mode.VENTED
