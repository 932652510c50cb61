"""Bookmarks over REST: who may set, name and remove them, and that every page hears of them."""

from collections.abc import Iterator

import pytest

from recordings.read.reader import read_log
from tests.server.live_server import VIEWER_TOKEN, Page, TestServer, taken, wait_for

MARKS = "/api/recordings/current/bookmarks"


@pytest.fixture
def page(server: TestServer) -> Iterator[Page]:
    """It operates, and records."""
    page = server.operator()
    taken(page.post("/api/recordings", json={"name": "marked"}))
    wait_for(lambda: server.services.recorder.state().rows > 100, "rows")
    yield page
    page.delete("/api/recordings/current")


def test_a_bookmark_is_told_to_every_page_at_once_and_stays_in_the_recording(page: Page, server: TestServer) -> None:
    with server.page().sign_in(VIEWER_TOKEN).live() as watching:
        mark = page.post(MARKS, json={"label": "touched"}).json()
        told = watching.wait("status", lambda message: message["recording"]["bookmarks"] != [])["recording"]
    assert (mark["n"], mark["label"], told["bookmarks"]) == (1, "touched", [mark])
    row = server.services.history.newest
    assert row is not None and 0 <= row[0]["t_ns"] * 1e-9 - told["origin"] - mark["t"] < 60
    done = page.delete("/api/recordings/current").json()
    assert done["bookmarks"] == [mark] and page.get("/api/recordings").json()[0]["bookmarks"] == [mark]
    log = [text for _, _, text in read_log(server.services.folder.store.path(done["id"]))]
    assert any("bookmark 1 “touched”" in text for text in log)


def test_it_is_named_and_removed_while_it_is_recorded_and_after(page: Page, server: TestServer) -> None:
    for _ in range(2):
        taken(page.post(MARKS, json={}))
    id = server.services.recorder.state().id
    place = f"/api/recordings/{id}/bookmarks"
    assert page.patch(f"{place}/2", json={"label": "later"}).json()["bookmarks"][1]["label"] == "later"
    wait_for(lambda: [mark.label for mark in server.services.recorder.state().bookmarks] == ["", "later"], "the name")
    taken(page.delete("/api/recordings/current"))
    left = page.delete(f"{place}/1").json()["bookmarks"]
    assert [(mark["n"], mark["label"]) for mark in left] == [(2, "later")]
    assert page.patch(f"{place}/1", json={"label": "x"}).status_code == 404
    answer = page.patch(f"{place}/2", json={"label": "x" * 81})
    assert answer.status_code == 422 and "80" in answer.text


def test_viewers_see_bookmarks_and_change_none(page: Page, server: TestServer) -> None:
    taken(page.post(MARKS, json={}))
    id, viewer = server.services.recorder.state().id, server.page().sign_in(VIEWER_TOKEN)
    assert len(viewer.get(f"/api/recordings/{id}").json()["bookmarks"]) == 1
    place = f"/api/recordings/{id}/bookmarks/1"
    answers = viewer.post(MARKS, json={}), viewer.patch(place, json={"label": "x"}), viewer.delete(place)
    assert [answer.status_code for answer in answers] == [403] * 3
    other = server.page().sign_in()
    assert other.post(MARKS, json={}).status_code == 403, "the operator's token without the lease"
    assert other.patch(place, json={"label": "by a second person"}).status_code == 200


def test_nothing_is_marked_without_a_recording(server: TestServer) -> None:
    answer = server.operator().post(MARKS, json={})
    assert (answer.status_code, "no recording is running" in answer.text) == (409, True)
