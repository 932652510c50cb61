"""Macros on a real rig: done step by step, ended by any stop, shown to everybody, and kept for who wrote them."""

from pathlib import Path
from typing import Any

import pytest

from controller.schema.modes import Mode
from server.runs.macros.messages import MacroBody
from server.runs.macros.store import MACROS_MAX
from tests.server.live_server import (
    VIEWER_TOKEN,
    Live,
    Page,
    RigProcess,
    TestServer,
    free_environment,
    key_file,
    wait_for,
)
from tests.server.runs.test_runs import CIRCLE, armed

RING = {"name": "ring", "points": CIRCLE, "closed": True, "timing": {"kind": "duration", "duration": 1.5}}
LONG: list[dict[str, Any]] = [
    {"do": "arm"},
    {"do": "target", "x": 0.05, "y": 0.14},
    {"do": "wait", "seconds": 600},
    {"do": "hold"},
]


def keep(page: Page, name: str, steps: list[dict[str, Any]]) -> None:
    answer = page.put(f"/api/macros/{name}", json={"steps": steps})
    assert answer.status_code == 200, answer.text


def begin(page: Page, name: str) -> dict[str, Any]:
    answer = page.post(f"/api/macros/{name}/run")
    assert answer.status_code == 200, answer.text
    return answer.json()  # type: ignore[no-any-return]


def told(live: Live) -> dict[str, Any]:
    """The newest state of the macro that the page was told."""
    states = [text["macro"] for text in live.texts if text["type"] == "status" and text["macro"]]
    return states[-1] if states else {"state": None, "step": 0, "reason": ""}


def wait_step(live: Live, step: int) -> None:
    """Wait until it has come to this step."""
    wait_for(lambda: told(live)["step"] >= step or told(live)["state"] in ("done", "ended"), f"step {step}")
    assert (told(live)["state"], told(live)["step"]) == ("running", step), told(live)["reason"]


def wait_end(live: Live) -> dict[str, Any]:
    wait_for(lambda: told(live)["state"] in ("done", "ended"), "the macro's end")
    return told(live)


def logged(live: Live) -> list[str]:
    return [text["text"] for text in live.texts if text["type"] == "event"]


def test_every_kind_of_step_is_done_in_order_and_told_to_everybody(server: TestServer) -> None:
    page, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    assert page.put("/api/drawings/ring", json=RING).status_code == 200
    steps: list[dict[str, Any]] = [
        {"do": "preset", "name": "Paths that repeat"},
        {"do": "arm"},
        {"do": "arm"},
        {"do": "record", "name": "warm"},
        {"do": "target", "x": 0.05, "y": 0.14},
        {"do": "wait", "seconds": 0.5},
        {"do": "hold"},
        {"do": "drawing", "name": "ring", "laps": 2},
        {"do": "mark", "label": "under way"},
        {"do": "run_end"},
        {"do": "record_end"},
        {"do": "clear"},
    ]
    keep(page, "warm-up", steps)
    with page.live() as live, viewer.live() as other:
        live.operate()
        begun = begin(page, "warm-up")
        assert [begun[name] for name in ("state", "step", "steps")] == ["running", 1, 12]
        done = wait_end(live)
        assert (done["state"], done["step"], done["reason"]) == ("done", 12, ""), logged(live)
        assert wait_end(other) == done
        assert page.get("/api/settings").json()["K_FF"][0] > 0
        result = page.get("/api/runs").json()[0]
        assert (result["name"], result["state"], result["laps"]) == ("ring", "done", 2.0)
        recording = page.get(f"/api/recordings/{result['recording']}").json()
        assert (recording["name"], [mark["label"] for mark in recording["bookmarks"]]) == ("warm", ["under way"])
        lines = logged(live)
        assert f"{done['by']}: macro warm-up started, 12 steps" in lines and "macro warm-up done" in lines
        assert "macro warm-up, step 6 of 12, wait 0.5 s" in lines


@pytest.mark.parametrize("stop", ["hold", "e_stop", "rest", "stop", "target", "release", "leave"])
def test_any_stop_and_whatever_else_is_asked_for_ends_it(stop: str, server: TestServer) -> None:
    page = server.operator()
    keep(page, "long", LONG)
    with page.live() as live:
        live.operate()
        begin(page, "long")
        wait_step(live, 3)
        live.wait_mode(Mode.FOLLOW)
        second = page.post("/api/macros/long/run")
        assert second.json()["detail"] == "macro long runs, step 3; stop it first"
        match stop:
            case "stop":
                page.post("/api/macros/stop")
            case "target":
                live.send(type="target", id=1, x=0.06, y=0.13, start=False)
            case "release":
                page.delete("/api/lease")
            case "leave":
                live.operate(present=False)
            case _:
                page.command(stop)
        ended = wait_end(live)
        assert (ended["state"], ended["step"]) == ("ended", 3)
        reason = {
            "hold": f"HOLD, asked for by {ended['by']}",
            "e_stop": "E-STOP",
            "rest": f"REST, asked for by {ended['by']}",
            "stop": f"stopped by {ended['by']}",
            "target": f"another target, asked for by {ended['by']}",
            "release": f"{ended['by']} no longer operates",
            "leave": "the rig is in HOLD (operator lost)",
        }
        assert ended["reason"] == reason[stop]
        mode = {"e_stop": Mode.E_STOP, "rest": Mode.VENTED, "target": Mode.FOLLOW}
        live.wait_mode(mode.get(stop, Mode.HOLD))
        assert f"macro long ended at step 3 of 4, wait 600 s: {ended['reason']}" in logged(live)
        if stop != "release":
            assert page.post("/api/macros/stop").json()["detail"] == "no macro runs"


def test_hold_ends_a_macro_that_moves_nothing_and_it_arms_no_more(server: TestServer) -> None:
    page = server.operator()
    keep(page, "late", [{"do": "wait", "seconds": 600}, {"do": "arm"}])
    with page.live() as live:
        live.operate()
        begin(page, "late")
        wait_step(live, 1)
        assert page.command("hold").status_code == 409, "the rig is vented"
        assert wait_end(live)["reason"].startswith("HOLD, asked for by")
        assert live.frames[-1]["mode"] == Mode.VENTED


def test_a_run_that_it_began_ends_with_it(server: TestServer) -> None:
    with armed(server) as (page, live):
        assert page.put("/api/drawings/ring", json=RING).status_code == 200
        keep(page, "laps", [{"do": "drawing", "name": "ring", "laps": 1000}, {"do": "run_end"}, {"do": "clear"}])
        begin(page, "laps")
        wait_step(live, 2)
        page.post("/api/macros/stop")
        live.wait_mode(Mode.HOLD)
        result = wait_for(lambda: page.get("/api/runs").json(), "the result")[0]
        assert (result["state"], result["reason"]) == ("stopped", "the operator asked for HOLD")
        begin(page, "laps")
        wait_for(lambda: told(live)["state"] == "running", "the macro")
        wait_step(live, 2)
        assert page.post("/api/run/stop").status_code == 200
        assert wait_end(live)["reason"].startswith("HOLD, asked for by")


def test_a_step_that_is_refused_says_which_and_why_and_holds(server: TestServer) -> None:
    with armed(server) as (page, live):
        keep(page, "bad", [LONG[1], {"do": "drawing", "name": "nowhere"}, {"do": "wait", "seconds": 600}])
        begin(page, "bad")
        ended = wait_end(live)
        assert (ended["state"], ended["step"], ended["doing"]) == ("ended", 2, "follow nowhere")
        assert ended["reason"] == "there is no drawing 'nowhere'"
        live.wait_mode(Mode.HOLD)


def test_a_row_from_before_the_last_clear_does_not_end_it(server: TestServer) -> None:
    page, macros = server.operator(), server.services.macros
    keep(page, "long", [{"do": "wait", "seconds": 600}])
    with page.live() as live:
        begin(page, "long")
        wait_step(live, 1)
        run = macros._run
        assert run is not None
        run.mode = Mode.E_STOP  # as the newest row had it when the macro began
        wait_for(lambda: run.mode == Mode.VENTED, "a look")
        assert macros.state() == run.view() and run.state == "running"
        run.mode = Mode.HOLD
        assert wait_end(live)["reason"].startswith("the rig is in VENTED")


@pytest.mark.process
def test_it_ends_with_the_rig_and_does_not_go_on_with_the_next_boot(tmp_path: Path) -> None:
    free_environment()
    rig = RigProcess(tmp_path)
    server = TestServer(tmp_path / "server", rig.endpoint, key_file(tmp_path))
    try:
        page = server.operator()
        keep(page, "long", [{"do": "wait", "seconds": 600}, {"do": "arm"}])
        with page.live() as live:
            begin(page, "long")
            wait_step(live, 1)
            rig.kill()
            assert wait_end(live)["reason"] == "the rig is gone"
            assert page.post("/api/macros/long/run").status_code in (409, 503)
    finally:
        server.close()
        rig.stop()


def test_only_who_operates_runs_one_and_each_browser_has_its_own(server: TestServer) -> None:
    page, idle, viewer = server.operator(), server.page().sign_in(), server.page().sign_in(VIEWER_TOKEN)
    keep(page, "mine", [{"do": "hold"}])
    keep(idle, "other", [{"do": "hold"}, {"do": "mark"}])
    assert [macro["name"] for macro in page.get("/api/macros").json()] == ["mine"]
    assert idle.get("/api/macros").json() == [{"name": "other", "steps": [{"do": "hold"}, {"do": "mark", "label": ""}]}]
    for other in (idle, viewer):
        assert other.post("/api/macros/other/run").status_code == 403
        assert other.post("/api/macros/stop").status_code == 403
    assert viewer.put("/api/macros/x", json={"steps": [{"do": "hold"}]}).status_code == 403
    assert page.post("/api/macros/other/run").status_code == 404
    assert page.delete("/api/macros/mine").json() == []


def test_what_cannot_be_done_is_refused_by_field_and_bound(server: TestServer) -> None:
    page = server.operator()
    for step, field, text in (
        ({"do": "wait", "seconds": 0}, "seconds", "greater than or equal to 0.1"),
        ({"do": "target", "x": 9, "y": 0}, "x", "less than or equal to 2"),
        ({"do": "reference", "name": "vu", "laps": 0}, "laps", "greater than or equal to 1"),
        ({"do": "drawing", "name": "../x"}, "name", "a name has letters"),
        ({"do": "dance"}, None, "'arm', 'hold'"),
    ):
        answer = page.put("/api/macros/odd", json={"steps": [{"do": "hold"}, step]})
        assert answer.status_code == 422
        said = answer.json()["detail"][0]
        assert text in said["msg"] and said["loc"][:3] == ["body", "steps", 1], said
        assert field in (None, said["loc"][-1])
    assert page.put("/api/macros/odd", json={"steps": []}).status_code == 422
    assert page.put("/api/macros/odd", json={"steps": [{"do": "hold"}] * 101}).status_code == 422
    who = server.services.lease.holder
    assert who is not None
    for n in range(MACROS_MAX):
        server.services.macro_store.write(who, f"m{n}", MacroBody.model_validate({"steps": [{"do": "hold"}]}))
    answer = page.put("/api/macros/more", json={"steps": [{"do": "hold"}]})
    assert (answer.status_code, answer.json()["detail"]) == (409, "50 macros are kept: delete one first")
