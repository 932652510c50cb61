"""A session ends: by another role, by signing out, by being signed out; and a copy of its cookie ends with it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from websockets.exceptions import InvalidStatus

from controller.schema.modes import Cause, Mode
from server.access import ended
from server.access.ended import EndedSessions
from server.access.lease import OperatorLease
from server.access.sessions import Sessions, cookie_name
from server.access.tokens import Secrets
from server.http.rates import POLICY
from server.http.who import Identity
from tests.server.live_server import TOKEN, VIEWER_TOKEN, Page, RigProcess, TestServer, wait_for

SECRETS = Secrets(token="right", viewer_token="look", key="k" * 20)


@pytest.fixture
def second(shared_rig: RigProcess, tmp_path: Path) -> Iterator[TestServer]:
    """Another server on this host, of a rig of the same name."""
    found = TestServer(tmp_path, shared_rig.endpoint)
    yield found
    found.close()


def copied(server: TestServer, page: Page) -> Page:
    """Another browser, with the cookie that `page` has now."""
    copy = server.page()
    copy.cookies.update(page.cookies)
    return copy


def opened(page: Page) -> int:
    """The status with which the page is let in."""
    return page.get("/api/session").status_code


def test_a_cookie_copied_from_a_viewer_is_worth_nothing_once_an_operator_signs_in_there(server: TestServer) -> None:
    browser = server.page().sign_in(VIEWER_TOKEN)
    copy, name = copied(server, browser), browser.get("/api/session").json()["name"]
    with copy.live() as live:
        live.wait("hello")
        browser.sign_in().operate()
        assert browser.get("/api/session").json()["name"] == name, "people know the browser by it"
        assert browser.command("e_stop").status_code == 200
        assert [copy.command(request).status_code for request in ("clear", "arm")] == [401, 401]
        assert copy.patch("/api/settings", json={"changes": {"K_P": [5.0, 5.0]}}).status_code == 401
        assert [copy.post("/api/lease").status_code, copy.delete("/api/lease").status_code] == [401, 401]
        assert browser.command("clear").status_code == 200
        wait_for(lambda: live.socket.close_code, "the end of the copy's socket")
        assert live.socket.close_code == POLICY
    with pytest.raises(InvalidStatus):
        copy.connect("/ws/live")


def test_who_gives_the_operators_role_up_leaves_no_operators_cookie_behind(server: TestServer) -> None:
    browser = server.operator()
    copy = copied(server, browser)
    browser.sign_in(VIEWER_TOKEN)
    assert (opened(copy), browser.get("/api/session").json()["role"]) == (401, "viewer")
    assert not browser.get("/api/session").json()["lease"]["held"]


def test_the_lease_is_of_a_session_and_the_token_that_opened_it() -> None:
    lease = OperatorLease()
    viewer, operator = Identity("a", "ann", "viewer", "mark 1"), Identity("a", "ann", "operator", "mark 2")
    assert lease.acquire(operator)
    term = lease.term
    assert not lease.acquire(viewer)
    assert (lease.holds(viewer), lease.touch(viewer), lease.release(viewer)) == (False, None, False)
    assert (lease.term_of(operator), lease.term) == (term, term)
    assert viewer.tag != operator.tag
    lease.give(viewer, "taken over")
    assert (lease.holds(operator), lease.term) == (False, term + 1)


def test_signing_out_ends_every_copy_frees_control_and_holds_the_motion(server: TestServer) -> None:
    page = server.operator()
    copy = copied(server, page)
    with page.live() as live:
        live.operate()
        assert page.command("arm").status_code == 200
        live.wait_mode(Mode.HOLD)
        live.send(type="target", id=1, x=0.15, y=0.12, start=True)
        live.wait_mode(Mode.FOLLOW)
        assert page.delete("/api/session").status_code == 204
        history = server.services.history
        wait_for(lambda: history.newest is not None and history.newest[0]["mode"] == Mode.HOLD, "HOLD")
        assert history.newest is not None and history.newest[0]["cause"] == Cause.OPERATOR
    assert not page.cookies, "the browser has nothing left"
    assert (opened(page), opened(copy)) == (401, 401)
    other = server.page().sign_in()
    assert not other.get("/api/session").json()["lease"]["held"]
    again = EndedSessions(next(server.settings.state.glob("sessions-*-test.json")))
    restarted = Sessions(server.services.secrets, server.services.sessions.cookie, again)
    assert restarted.read(copy.cookies) is None, "nor does a restart raise it again"
    assert restarted.read(other.cookies) is not None


def test_an_operator_signs_all_of_a_token_out_and_the_token_stays(server: TestServer) -> None:
    operator, viewers = server.operator(), [server.page().sign_in(VIEWER_TOKEN) for _ in range(2)]
    assert operator.delete("/api/sessions/viewer").status_code == 204
    assert [opened(page) for page in (operator, *viewers)] == [200, 401, 401]
    assert opened(viewers[0].sign_in(VIEWER_TOKEN)) == 200
    other = server.page().sign_in()
    assert other.delete("/api/sessions/operator").status_code == 204
    assert [opened(page) for page in (operator, other, viewers[0])] == [401, 401, 200]
    assert server.services.lease.holder is None
    assert server.page().sign_in().operate()


def test_a_viewer_signs_no_one_out_though_it_was_handed_the_lease(server: TestServer) -> None:
    operator, viewer = server.operator(), server.page().sign_in(VIEWER_TOKEN)
    with viewer.live() as theirs:
        theirs.wait("hello")
        [who] = wait_for(server.services.pages.present, "the viewer's page")
        assert operator.post("/api/lease/hand-over", json={"tag": who.tag}).status_code == 200
        for role in ("operator", "viewer"):
            assert viewer.delete(f"/api/sessions/{role}").status_code == 403
        assert viewer.delete("/api/sessions/all").status_code == 422
    assert (opened(operator), opened(viewer)) == (200, 200)


def test_what_a_browser_keeps_for_itself_stays_when_its_role_changes(server: TestServer) -> None:
    page = server.page().sign_in(VIEWER_TOKEN)
    limits = page.get("/api/alarms").json() | {"residual": {"amber": 0.001, "red": 0.002}}
    assert page.put("/api/alarms", json=limits).is_success
    assert page.sign_in().get("/api/alarms").json() == limits
    page.delete("/api/session")
    assert page.sign_in().get("/api/alarms").json() != limits, "the next person at this machine begins with nothing"


def test_two_servers_of_one_host_keep_their_cookies_apart(server: TestServer, second: TestServer) -> None:
    page = server.page().sign_in()
    assert page.post(f"{second.url}/api/session", json={"token": TOKEN}).status_code == 200
    assert {page.get(f"{one.url}/api/session").status_code for one in (server, second)} == {200}
    assert len(page.cookies) == 2
    page.delete(f"{second.url}/api/session")
    assert [page.get(f"{one.url}/api/session").status_code for one in (server, second)] == [200, 401]


def test_a_cookie_is_good_for_the_server_that_gave_it_alone() -> None:
    one, other = (Sessions(SECRETS, cookie_name("rig", port)) for port in (8321, 8322))
    sealed = one.seal(one.open("right", "here"))
    assert one.read({one.cookie: sealed}) is not None
    assert other.read({other.cookie: sealed}) is None, "or signing out of one would leave the other open"


@pytest.mark.parametrize("content", [b"", b'{"operator": {"ids": 1}}', b"\xff\x00"])
def test_a_damaged_file_of_what_ended_ends_every_session(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "sessions.json"
    before = Sessions(SECRETS, "c", EndedSessions(path))
    cookie = {"c": before.seal(before.open("right", "here"))}
    path.write_bytes(content)
    after = Sessions(SECRETS, "c", EndedSessions(path))
    assert after.read(cookie) is None
    cookie = {"c": after.seal(after.open("right", "here"))}
    assert Sessions(SECRETS, "c", EndedSessions(path)).read(cookie) is not None, "once, not at every start"


def test_who_signs_in_and_out_without_end_raises_no_session_of_the_other_role(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ended, "ENDED_MAX", 3)
    ours = Sessions(SECRETS, "c")
    operator, viewers = ours.open("right", "here"), [ours.open("look", "here") for _ in range(5)]
    for who in (operator, *viewers):
        ours.end(who)
    assert [ours.stands(who) for who in (operator, *viewers)] == [False, True, True, False, False, False]
