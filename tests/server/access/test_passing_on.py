"""The lease passes from one session to another: asked for, handed over, taken over; and what two tabs of one do."""

from typing import Any

from controller.schema.modes import Cause, Mode
from tests.server.live_server import VIEWER_TOKEN, Live, Page, TestServer, wait_for


def name(page: Page) -> str:
    return str(page.get("/api/session").json()["name"])


def follow(page: Page, live: Live) -> None:
    live.operate()
    assert page.command("arm").status_code == 200
    live.wait_mode(Mode.HOLD)
    live.send(type="target", id=1, x=0.15, y=0.12, start=True)
    live.wait_mode(Mode.FOLLOW)


def people(live: Live, which: Any) -> dict[str, Any]:
    return live.wait("status", lambda m: which(m["people"]))["people"]  # type: ignore[no-any-return]


def test_a_viewer_asks_is_handed_the_lease_and_may_then_operate_but_not_before(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    with operator.live() as ours, viewer.live() as theirs:
        follow(operator, ours)
        assert viewer.post("/api/lease/request").status_code == 200
        asker = people(ours, lambda p: p["asking"])["asking"][0]
        assert (asker["name"], asker["role"]) == (name(viewer), "viewer")
        assert people(theirs, lambda p: p["waiting"])["asking"]
        assert viewer.patch("/api/lease", json={"clutch": True}).status_code == 403
        lease = operator.post("/api/lease/hand-over", json={"tag": asker["tag"]}).json()
        assert (lease["mine"], lease["holder"]) == (False, name(viewer))
        ours.wait_mode(Mode.HOLD)
        assert not people(theirs, lambda p: not p["waiting"])["asking"]
        theirs.operate()
        assert viewer.patch("/api/lease", json={"clutch": False}).status_code == 200
        assert operator.patch("/api/lease", json={"clutch": False}).status_code == 403
        theirs.send(type="target", id=2, x=0.16, y=0.12, start=True)
        theirs.wait_mode(Mode.FOLLOW)
        handed = f"{name(operator)} handed control over to {name(viewer)}"
        assert ours.wait("event", lambda m: m["text"] == handed)
        assert theirs.wait("event", lambda m: m["text"] == handed)
        assert viewer.delete("/api/lease").status_code == 200
        assert viewer.post("/api/lease").status_code == 403, "by itself it takes nothing"


def test_a_request_may_be_refused_or_withdrawn(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    with operator.live() as ours, viewer.live():
        viewer.post("/api/lease/request")
        tag = people(ours, lambda p: p["asking"])["asking"][0]["tag"]
        assert viewer.post("/api/lease/refuse", json={"tag": tag}).status_code == 403
        assert operator.post("/api/lease/refuse", json={"tag": tag}).status_code == 200
        assert operator.post("/api/lease/refuse", json={"tag": tag}).status_code == 409
        viewer.post("/api/lease/request")
        viewer.delete("/api/lease/request")
        assert operator.post("/api/lease/refuse", json={"tag": tag}).status_code == 409
        assert operator.post("/api/lease/hand-over", json={"tag": "0" * 12}).status_code == 409, "not here"
        assert operator.post("/api/lease/hand-over", json={"tag": "x"}).status_code == 422
        assert operator.post("/api/lease/request").status_code == 409, "it operates already"


def test_an_operator_takes_over_from_whom_it_named_and_the_motion_is_held(server: TestServer) -> None:
    first, second, viewer = server.operator(), server.page().sign_in(), server.page().sign_in(VIEWER_TOKEN)
    with first.live() as ours, second.live() as theirs:
        follow(first, ours)
        tag = people(theirs, lambda p: p["holder"])["holder"]
        assert viewer.post("/api/lease/take-over", json={"tag": tag}).status_code == 403
        assert second.post("/api/lease/take-over", json={"tag": "0" * 12}).status_code == 409
        before = ours.wait_mode(Mode.FOLLOW)["request_n"]
        assert second.post("/api/lease/take-over", json={"tag": tag}).json()["mine"]
        held = wait_for(lambda: ours.frames[-1]["request_n"] > before and ours.frames[-1], "the rig's answer")
        assert held["mode"] == Mode.HOLD
        assert held["cause"] == Cause.OPERATOR
        taken = f"{name(second)} took control from {name(first)}"
        for live in (ours, theirs):
            assert live.wait("event", lambda m: m["text"] == taken)["level"] == "warning"
        assert first.command("arm").status_code == 403
        assert first.command("clear").status_code == 403, "only the holder clears"


def test_of_two_tabs_both_operate_and_closing_the_one_that_moved_the_target_holds(server: TestServer) -> None:
    page = server.operator()
    with page.live() as stays:
        with page.live() as goes:
            stays.operate()
            follow(page, goes)
            assert all(m["lease"]["mine"] for m in (stays.wait("status"), goes.wait("status")))
            stays.send(type="target", id=7, x=0.15, y=0.11)
            assert stays.wait("reply", lambda m: m["id"] == 7)["reply"]["accepted"]
        held = stays.wait_mode(Mode.HOLD)
        assert held["cause"] == Cause.OPERATOR, "not the watchdog: the other tab was present all the time"
        assert page.get("/api/session").json()["lease"]["mine"]


def test_closing_the_idle_one_of_two_tabs_changes_nothing_and_a_reload_keeps_the_lease(server: TestServer) -> None:
    page = server.operator()
    with page.live() as moves:
        with page.live():
            follow(page, moves)
        tick = moves.frames[-1]["tick"]
        later = wait_for(lambda: moves.frames[-1]["tick"] > tick + 2200 and moves.frames[-1], "2.2 s")
        assert later["mode"] == Mode.FOLLOW
    history = server.services.history
    wait_for(lambda: history.newest is not None and history.newest[0]["mode"] == Mode.HOLD, "HOLD")
    with page.live() as again:
        assert again.wait("hello")["session"]["lease"]["mine"]
        again.operate()
        assert again.wait_mode(Mode.HOLD)["cause"] == Cause.OPERATOR_LOST
        tick = again.frames[-1]["tick"]
        assert (
            wait_for(lambda: again.frames[-1]["tick"] > tick + 700 and again.frames[-1], "0.7 s")["mode"] == Mode.HOLD
        )
