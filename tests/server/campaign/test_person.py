"""The campaign's person asks nothing twice."""

import socketserver
import threading
from collections.abc import Iterator

import pytest

from server.campaign.person import Person, http_client
from server.campaign.waiting import Failed

asked: list[bytes] = []


class NoAnswer(socketserver.BaseRequestHandler):
    """A server that takes a request to heart and never answers it."""

    def handle(self) -> None:
        asked.append(self.request.recv(4096))


@pytest.fixture
def origin() -> Iterator[str]:
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), NoAnswer) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


@pytest.mark.parametrize("method", ["POST", "GET"])
def test_what_is_not_answered_is_asked_once(method: str, origin: str) -> None:
    asked.clear()
    person = Person.__new__(Person)
    person._http = http_client(origin)
    with pytest.raises(Failed, match=f"{method} /api/run"):
        person.request(method, "/api/run")
    assert [line.split()[0] for line in asked] == [method.encode()]
