"""Which controller is in the slot, over HTTP, on the real rig process."""

from collections.abc import Iterator

import pytest

from controller.assembly.controllers.registry import index_of
from controller.schema.modes import Mode
from tests.server.live_server import Page, TestServer
from tests.waiting import wait_for

pytestmark = pytest.mark.process


@pytest.fixture
def operator(server: TestServer) -> Iterator[Page]:
    page = server.operator()
    yield page
    page.put("/api/controller", json={"name": "preview"})


def choose(page: Page, name: str, **tuning: float) -> tuple[int, object]:
    """Status, and controller with the first three numbers, or the refusal."""
    answer = page.put("/api/controller", json={"name": name, "tuning": tuning})
    told = answer.json()
    return answer.status_code, (
        (told["controller"], told["tuning"][:3]) if answer.status_code == 200 else told["detail"]
    )


def test_a_controller_is_chosen_by_name_and_tuned_within_its_bounds(operator: Page) -> None:
    number = index_of("preview")
    assert choose(operator, "preview") == (200, (number, [0.3, 4.0, 0.1]))
    assert choose(operator, "preview", K_P=0.5) == (200, (number, [0.5, 4.0, 0.1]))
    for name, tuning, complaint in [
        ("mpc", {}, "controller = 'mpc' is not one of paper, letter, preview, adaptive"),
        ("preview", {"K_D": 1.0}, "tuning.K_D: the numbers of controller preview are K_P, K_I, lag"),
        ("preview", {"K_I": 21.0}, "tuning.K_I = 21 is outside [0, 20] 1/s"),
        ("paper", {"K_P": 1.0}, "tuning.K_P: the numbers of controller paper are none"),
    ]:
        assert choose(operator, name, **tuning) == (422, complaint)
    assert operator.get("/api/settings").json()["tuning"][:3] == [0.5, 4.0, 0.1]
    changed = operator.patch("/api/settings", json={"changes": {"controller": index_of("letter")}})
    assert changed.json()["tuning"] == [0.0] * 16, "as usual: it has none"


def test_it_changes_in_hold_and_not_while_the_tip_is_on_its_way(operator: Page) -> None:
    with operator.live() as live:
        live.operate()
        operator.command("arm")
        operator.command("follow", target=(0.2, 0.05))
        live.wait_mode(Mode.FOLLOW)
        status, detail = choose(operator, "paper")
        assert status == 409 and "changes in HOLD" in str(detail)
        assert choose(operator, "preview")[0] == 200, "a server begins with it"
        operator.command("hold")
        live.wait_mode(Mode.HOLD)
        assert choose(operator, "paper")[0] == 200
        wait_for(lambda: live.frames[-1]["controller"] == index_of("paper"), "paper in the slot")
        operator.command("rest")
