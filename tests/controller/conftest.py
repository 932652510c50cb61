from collections.abc import Iterator

import pytest

from controller.realtime.settings import free_port
from tests.controller.fake_rig import FakeRig


@pytest.fixture
def endpoint() -> str:
    return free_port("tcp/127.0.0.1:0")


@pytest.fixture
def rig(endpoint: str) -> Iterator[FakeRig]:
    rig = FakeRig(endpoint, boot=1)
    yield rig
    rig.close()
