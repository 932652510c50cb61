from collections.abc import Iterator

import pytest

from server.access import lease
from tests.server.live_server import RigProcess, TestServer, free_environment


@pytest.fixture(autouse=True)
def slow_operators(monkeypatch: pytest.MonkeyPatch) -> None:
    """A page that only posts keeps the lease on a busy machine, too; that one lapses is shown on a clock of its own."""
    monkeypatch.setattr(lease, "LAPSE", 60.0)


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
