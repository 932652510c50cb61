"""Paths that are learned by repeating them on a real rig: by one button, kept, followed, forgotten."""

from typing import Any

import pytest

from server.runs.macros.messages import MacroState
from tests.server.live_server import VIEWER_TOKEN, Live, Page, TestServer, wait_for
from tests.server.runs.test_runs import armed, ring, wait_run

pytestmark = pytest.mark.alone

RING = {**ring(1.5), "record": False}


def told(live: Live) -> MacroState | None:
    """The newest state of the series that the page was told."""
    found = [text["macro"] for text in live.texts if text["type"] == "status" and text["macro"]]
    return MacroState.model_validate(found[-1]) if found else None


def learn(page: Page, live: Live, body: dict[str, Any]) -> MacroState:
    """Its end."""
    answer = page.post("/api/run/learn", json=body)
    assert answer.status_code == 200, answer.text
    return wait_for(lambda: (found := told(live)) and found.state != "running" and found, "the repeats")  # type: ignore[no-any-return]


def results(page: Page) -> list[dict[str, Any]]:
    """Newest first."""
    return page.get("/api/runs").json()  # type: ignore[no-any-return]


def run_once(page: Page, live: Live, body: dict[str, Any]) -> dict[str, Any]:
    begun = page.run(json=body).json()
    wait_run(live, lambda state: state["state"] == "done", begun["id"])
    return results(page)[0]


def test_a_drawing_is_learned_by_one_button_and_followed_so_until_it_is_forgotten(server: TestServer) -> None:
    with armed(server) as (page, live):
        end = learn(page, live, {**RING, "repeats": 4})
        assert (end.state, end.learning, end.name, end.step, end.steps) == ("done", True, "ring", 4, 4), end.reason
        runs = results(page)
        assert [run["learned"]["learning"] for run in runs] == [True] * 4
        assert [len(run["learned"]["errors"]) for run in runs] == [4, 3, 2, 1]
        assert [run["learned"]["errors"][-1] for run in runs] == [run["rmse"] for run in runs]
        errors = runs[0]["learned"]["errors"]
        assert min(errors[1:]) < 0.75 * errors[0], errors

        usual = run_once(page, live, RING)["learned"]
        assert usual == {"key": runs[0]["learned"]["key"], "learning": False, "errors": errors}
        assert run_once(page, live, {**RING, "learning": "off"})["learned"] is None
        foreseen = page.post("/api/preview", json={"drawing": RING["drawing"]})
        assert foreseen.status_code == 200, foreseen.text

        on = run_once(page, live, {**RING, "learning": "on"})["learned"]
        assert on["errors"][:4] == errors and len(on["errors"]) == 5
        assert page.delete(f"/api/learned/{usual['key']}").status_code == 200
        assert page.delete(f"/api/learned/{usual['key']}").status_code == 404
        assert run_once(page, live, RING)["learned"] is None


def test_a_controller_without_a_plan_learns_nothing_and_the_page_hears_why(server: TestServer) -> None:
    with armed(server) as (page, live):
        assert page.put("/api/controller", json={"name": "paper"}).status_code == 200
        end = learn(page, live, {**RING, "repeats": 2})
        assert end.state != "done"
        assert "controller paper follows no planned torques" in end.reason and "preview" in end.reason


def test_a_repeat_that_is_stopped_ends_the_series_and_teaches_nothing(server: TestServer) -> None:
    with armed(server) as (page, live):
        assert page.post("/api/run/learn", json={**RING, "repeats": 9}).status_code == 200
        wait_run(live, lambda state: state["state"] == "running" and state["progress"] > 0.1)
        assert page.post("/api/run/stop").status_code == 200
        wait_for(lambda: (found := told(live)) and found.state != "running", "the series")
        ended = results(page)[0]
        assert (ended["state"], ended["learned"]["errors"]) == ("stopped", [])
        assert not list((server.settings.state / "learned-test").glob("*"))


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ({"repeats": 0}, "repeats"),
        ({"repeats": 51}, "repeats"),
        ({"reference": "vu"}, "either a drawing or a reference"),
        ({"laps": 0}, "laps"),
    ],
)
def test_what_cannot_be_repeated_is_refused_by_name(server: TestServer, body: dict[str, Any], why: str) -> None:
    with armed(server) as (page, _):
        answer = page.post("/api/run/learn", json={**RING, **body})
        assert answer.status_code == 422 and why in answer.text


def test_a_viewer_teaches_and_forgets_nothing(server: TestServer) -> None:
    viewer = server.page().sign_in(VIEWER_TOKEN)
    assert viewer.post("/api/run/learn", json=RING).status_code == 403
    assert viewer.delete(f"/api/learned/{'0' * 24}").status_code == 403
