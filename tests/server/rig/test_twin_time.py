"""The twin's time through the server: who may stop it, what a page hears, and what ends it."""

from controller.schema.modes import Mode
from tests.server.live_server import TestServer, wait_for

PAUSED, GOING = {"paused": True, "steps": 0}, {"paused": False, "steps": 0}


def test_pages_hear_that_the_twin_is_paused_by_whom_and_that_it_goes_on(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in()
    assert viewer.put("/api/twin/time", json=PAUSED).status_code == 403
    with viewer.live() as live:
        assert operator.put("/api/twin/time", json=PAUSED).json() == PAUSED
        live.wait("event", lambda event: event["text"].endswith("paused the twin"))
        health = live.wait("status", lambda status: status["health"]["paused"])["health"]
        assert health["rig_connected"]
        assert health["rig_age"] < 0.6
        assert viewer.get("/api/twin/time").json() == PAUSED
        assert operator.put("/api/twin/time", json=GOING).json() == GOING
        live.wait("event", lambda event: event["text"].endswith("let the twin go on"))
        live.wait("status", lambda status: not status["health"]["paused"])


def test_nothing_begins_while_the_twin_is_paused_and_each_refusal_says_why(server: TestServer) -> None:
    operator = server.operator()
    operator.put("/api/twin/time", json=PAUSED)
    wait_for(lambda: operator.get("/api/health").json()["paused"], "the pause")
    for path, body in (("command", {"request": "arm"}), ("run", {"reference": "circle_0.25hz"})):
        answer = operator.post(f"/api/{path}", json=body)
        assert answer.status_code == 409, path
        assert "the twin is paused; continue it first" in answer.json()["detail"], path
    operator.put("/api/twin/time", json=GOING)


def test_a_pause_ends_with_the_control_of_who_paused(server: TestServer) -> None:
    operator = server.operator()
    assert operator.command("arm").status_code == 200
    operator.put("/api/twin/time", json=PAUSED)
    wait_for(lambda: operator.get("/api/health").json()["paused"], "the pause")
    assert operator.delete("/api/lease").status_code == 200
    wait_for(lambda: not operator.get("/api/health").json()["paused"], "the end of the pause")
    assert operator.get("/api/twin/time").json() == GOING
    with operator.live() as live:
        live.wait_mode(Mode.HOLD)


def test_steps_beyond_their_bound_are_refused_with_field_value_and_bound(server: TestServer) -> None:
    operator = server.operator()
    answer = operator.put("/api/twin/time", json={"paused": True, "steps": 10_001})
    assert answer.status_code == 422
    assert all(word in answer.text for word in ("steps", "10001", "10000"))
    answer = operator.put("/api/twin/time", json={"paused": False, "steps": 3})
    assert answer.status_code in (409, 422)
    assert "steps = 3" in answer.text


def test_an_e_stop_ends_a_pause_and_is_cleared_as_any_other(server: TestServer) -> None:
    operator = server.operator()
    operator.put("/api/twin/time", json=PAUSED)
    answer = operator.command("e_stop")
    assert answer.status_code == 200
    answer = operator.command("clear")
    assert answer.status_code == 200, answer.text
