"""The recordings over REST: search, edits, removal, metrics, and ids that try to get out."""

from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import httpx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters, Settings
from recordings.format import sidecar
from recordings.write.run_file import simulated_rig
from recordings.write.writer import Recorder
from tests.recordings.synthetic import telemetry_rows
from tests.server.live_server import Page, TestServer, wait_for

pytestmark = pytest.mark.process

LIST = "/api/recordings"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestServer]:
    """A server without a rig, with three recordings that were made before."""
    folder = tmp_path_factory.mktemp("server")
    for name in ("Circle slow", "circle fast", "eight"):
        _record(folder / "recordings", name)
    found = TestServer(folder, "tcp/127.0.0.1:9", rate_factor=1e6)
    yield found
    found.close()


@pytest.fixture(scope="module")
def page(server: TestServer) -> Page:
    return server.page().sign_in()


def test_the_list_is_searched_sorted_and_cut(page: Page) -> None:
    names = [found["name"] for found in page.get(LIST).json()]
    assert names == ["eight", "circle fast", "Circle slow"]
    assert _names(page, search="CIRCLE") == ["circle fast", "Circle slow"]
    assert _names(page, search="circle slow p1") == ["Circle slow"]
    assert _names(page, sort="name") == ["circle fast", "Circle slow", "eight"]
    assert _names(page, sort="-name", limit=1) == ["eight"]
    counted = page.get("/api/recordings", params={"search": "circle", "limit": 1})
    assert (len(counted.json()), counted.headers["x-found"], counted.headers["x-in-all"]) == (1, "2", "3")
    for wrong in ({"sort": "nothing"}, {"limit": 0}, {"search": "x" * 201}):
        assert page.get(LIST, params=wrong).status_code == 422


def test_what_people_say_of_a_recording_is_checked_and_kept(page: Page) -> None:
    id = _id(page, "eight")
    said = {"tags": ["good_1", "P1.2"], "notes": "n" * 4000, "starred": True}
    assert page.patch(f"{LIST}/{id}", json=said).json() == page.get(f"{LIST}/{id}").json()
    assert page.get(f"{LIST}/{id}").json().items() >= said.items()
    assert _names(page, search="good_1") == ["eight"]
    for wrong in (
        {"tags": ["two words"]},
        {"tags": [""]},
        {"tags": ["x" * 41]},
        {"tags": ["a\n"]},
        {"tags": [f"t{n}" for n in range(21)]},
        {"notes": "n" * 4001},
        {"name": ""},
        {"name": "x" * 81},
        {"rows": 1},
        {"id": "20261120-120000"},
    ):
        assert page.patch(f"{LIST}/{id}", json=wrong).status_code == 422, wrong
    assert page.get(f"{LIST}/{id}").json().items() >= said.items()


def test_a_starred_recording_is_removed_only_once_its_star_is_gone(server: TestServer, page: Page) -> None:
    id = _record(server.settings.recordings, "to go")
    page.patch(f"{LIST}/{id}", json={"starred": True})
    refused = page.delete(f"{LIST}/{id}")
    assert (refused.status_code, "starred" in refused.json()["detail"]) == (409, True)
    page.patch(f"{LIST}/{id}", json={"starred": False})
    assert page.delete(f"{LIST}/{id}").status_code == 204
    for ask in (page.get, page.delete):
        assert ask(f"{LIST}/{id}").status_code == 404
    assert page.get(f"{LIST}/{id}.rrd").status_code == 404
    assert id not in [found["id"] for found in page.get(LIST).json()]


def test_only_those_who_are_signed_in_may_read_edit_or_remove(server: TestServer, page: Page) -> None:
    stranger, id = server.page(), _id(page, "circle fast")
    for method, path in (("GET", ""), ("GET", "/metrics"), ("PATCH", ""), ("DELETE", "")):
        assert stranger.request(method, f"{LIST}/{id}{path}").status_code in (401, 403)
    assert page.get(f"{LIST}/{id}").status_code == 200


def test_metrics_come_whole_and_by_cycle_and_are_kept_after_the_end(server: TestServer, page: Page) -> None:
    id = _id(page, "circle fast")
    found = page.get(f"{LIST}/{id}/metrics").json()
    assert len(found["cycles"]) == 3
    assert found["whole"]["rmse"] > 0
    server.services.review.stopped(id)
    kept = wait_for(lambda: page.get(f"{LIST}/{id}").json()["metrics"], "the metrics")
    assert kept == pytest.approx(found["whole"], nan_ok=False)
    assert _names(page, sort="rmse", limit=1) == ["circle fast"]


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.one_of(
        st.text(max_size=60),
        st.lists(
            st.sampled_from(["..", ".", "/", "\\", "%2e", "%2f", "secret", ".json", "\x00", "20261120-120000"])
        ).map("".join),
    )
)
def test_no_id_gets_out_of_the_folder(server: TestServer, page: Page, text: str) -> None:
    folder = server.settings.recordings
    secret = folder.parent / "secret.json"
    secret.write_text("secret")
    before = sorted(path.name for path in folder.glob("*.rrd"))
    # The client would resolve a bare dot by itself.
    asked = quote(text.encode(errors="replace"), safe="").replace(".", "%2E") or "%20"
    for method, path in (("GET", ""), ("GET", "/metrics"), ("GET", ".rrd"), ("PATCH", ""), ("DELETE", "")):
        url = httpx.URL(str(page.base_url)).copy_with(raw_path=f"{LIST}/{asked}{path}".encode())
        answer = page.request(method, url, json={"notes": "x"} if method == "PATCH" else None)
        assert answer.status_code in (404, 405, 307), (method, text, answer.status_code)
        assert "secret" != answer.text
    assert secret.read_text() == "secret"
    assert sorted(path.name for path in folder.glob("*.rrd")) == before


def _record(folder: Path, name: str) -> str:
    recorder = Recorder(folder)
    recorder.start(name, simulated_rig(RigParameters()), Settings())
    rows = telemetry_rows(7000)
    rows["mode"] = Mode.TRACK
    recorder.rows(rows)
    done = recorder.stop()
    recorder.close()
    # Ids have seconds: these would all begin in the same one.
    number = {"Circle slow": 1, "circle fast": 2, "eight": 3}.get(name, 0)
    sidecar.update(folder, done.id, started=done.started.replace(microsecond=number))
    return done.id


def _names(page: Page, **query: object) -> list[str]:
    return [found["name"] for found in page.get(LIST, params=query).json()]


def _id(page: Page, name: str) -> str:
    return next(found["id"] for found in page.get(LIST).json() if found["name"] == name)
