"""Viser's page is fetched, made ours and compressed once, however many ask for it; what fails is not kept."""

import asyncio
import gzip
import threading
import time
from collections import Counter
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import httpx
import pytest

from server.http.frames import TELL_ESCAPE
from server.http.rates import HEAVY
from server.scene import viser_files
from server.scene.viser_files import ViserFiles
from tests.server.live_server import VIEWER_TOKEN, TestServer

PAGE = b"<html><head></head><body>" + b"viser " * 1000


class Upstream(ThreadingHTTPServer):
    """A server of files that counts what it is asked for."""

    def __init__(self, port: int = 0) -> None:
        super().__init__(("127.0.0.1", port), Handler)
        self.asked: Counter[str] = Counter()
        threading.Thread(target=self.serve_forever).start()

    def close(self) -> None:
        self.shutdown()
        self.server_close()


class Handler(BaseHTTPRequestHandler):
    server: Upstream

    def do_GET(self) -> None:
        self.server.asked[self.path] += 1
        self.send_response(404 if "none" in self.path else 200)
        self.send_header("content-type", "text/html")
        self.send_header("content-length", str(len(PAGE)))
        self.end_headers()
        self.wfile.write(PAGE)

    def log_message(self, *args: object) -> None:
        """Say nothing."""


@pytest.fixture
def upstream() -> Iterator[Upstream]:
    found = Upstream()
    yield found
    found.close()


def test_all_who_ask_at_once_and_later_get_one_fetched_file(upstream: Upstream) -> None:
    async def ask() -> None:
        files = ViserFiles(upstream.server_port)
        found = await asyncio.gather(*[files.file("") for _ in range(50)])
        assert await files.file("") is found[0] and len(set(map(id, found))) == 1
        body = gzip.decompress(found[0].body)
        assert (found[0].status, found[0].media, TELL_ESCAPE in body) == (200, "text/html", True)
        await files.close()

    asyncio.run(ask())
    assert upstream.asked == {"/": 1}


def test_what_is_not_there_is_asked_for_again_and_no_more_is_kept_than_viser_has(
    upstream: Upstream, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viser_files, "FILES_MAX", 3)

    async def ask() -> None:
        files = ViserFiles(upstream.server_port)
        assert [(await files.file("none")).status for _ in range(2)] == [404, 404]
        for name in ("a", "b", "c", "d", "d", "a"):
            assert (await files.file(name)).status == 200
        await files.close()

    asyncio.run(ask())
    assert upstream.asked == {"/none": 2, "/a": 2, "/b": 1, "/c": 1, "/d": 1}


def test_a_viser_that_did_not_answer_is_asked_again() -> None:
    first = Upstream()
    port = first.server_port
    first.close()

    async def ask() -> None:
        files = ViserFiles(port)
        with pytest.raises(httpx.HTTPError):
            await files.file("")
        again = Upstream(port)
        try:
            assert (await files.file("")).status == 200
        finally:
            again.close()
            await files.close()

    asyncio.run(ask())


def test_the_3d_view_is_heavy_and_who_asks_for_it_without_end_has_all_else(server: TestServer) -> None:
    server.operator()
    viewer, now = server.page().sign_in(VIEWER_TOKEN), time.monotonic()
    for bucket in vars(server.services.rates).values():
        bucket._now = lambda: now  # no token comes back, however slow the machine is
    answers = [viewer.get("/viser/") for _ in range(int(HEAVY.burst) + 20)]
    assert [one.status_code for one in answers] == [200] * int(HEAVY.burst) + [429] * 20
    assert answers[-1].json()["detail"].startswith(HEAVY.what)
    assert [viewer.get(path).status_code for path in ("/api/openapi.json", "/api/health")] == [429, 200]
    assert viewer.command("e_stop").status_code == 200
    tag = answers[0].headers["etag"]
    other = server.page().sign_in(VIEWER_TOKEN)
    assert other.get("/viser/", headers={"if-none-match": tag}).status_code == 304
