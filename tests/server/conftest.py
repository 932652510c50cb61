from collections.abc import Iterator

import pytest

from controller.link import client as link
from server.access import lease
from tests.server.live_server import RigProcess, TestServer, free_environment

PATIENT_QUIET = 3.0
"""Seconds without telemetry after which a server under test says that the rig is gone."""


@pytest.fixture(autouse=True)
def slow_operators(monkeypatch: pytest.MonkeyPatch) -> None:
    """A page that only posts keeps the lease on a busy machine, too; that one lapses is shown on a clock of its own."""
    monkeypatch.setattr(lease, "LAPSE_S", 60.0)


@pytest.fixture(autouse=True)
def patient_servers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Telemetry may be late by a second on a busy machine: no rig is gone for that, as none holds for it."""
    monkeypatch.setattr(link, "QUIET_S", PATIENT_QUIET)
    monkeypatch.setattr(link, "GONE_S", PATIENT_QUIET)


@pytest.fixture(scope="session")
def shared_rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RigProcess]:
    """One rig for all tests that do not kill it."""
    rig = RigProcess(tmp_path_factory.mktemp("rig"))
    yield rig
    rig.stop()


@pytest.fixture
def server(shared_rig: RigProcess, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestServer]:
    free_environment()
    found = TestServer(tmp_path_factory.mktemp("server"), shared_rig.endpoint)
    yield found
    found.close()
