"""What the OpenAPI says of signing in is what the server does, route by route."""

from collections.abc import Iterator
from typing import Any

from server.access.security import SESSION, TOKEN
from server.app.app import openapi_schema
from tests.server.access.test_roles import NEEDS, filled
from tests.server.live_server import TOKEN as OPERATORS
from tests.server.live_server import VIEWER_TOKEN, TestServer


def described() -> Iterator[tuple[str, str, list[dict[str, list[str]]]]]:
    for path, methods in openapi_schema()["paths"].items():
        for method, operation in methods.items():
            yield method.upper(), path, operation.get("security", [])


def test_what_is_described_as_closed_answers_401_to_a_stranger_and_nothing_else_does(server: TestServer) -> None:
    found = list(described())
    assert len(found) > 60
    for method, path, security in found:
        closed = bool(security) and {} not in security
        assert (server.page().request(method, filled(path)).status_code == 401) == closed, (method, path)


def test_a_session_opens_whatever_is_described_as_closed(server: TestServer) -> None:
    page = server.page().sign_in(VIEWER_TOKEN)
    for method, path, security in described():
        assert any(SESSION in way for way in security) == bool(security), (method, path)
        if not path.startswith("/api/session"):  # which ends sessions, too
            assert page.request(method, filled(path)).status_code != 401, (method, path)


def test_an_access_token_opens_what_is_described_so_alone(server: TestServer) -> None:
    for method, path, security in described():
        if not security or {} in security:
            continue
        for token in (OPERATORS, VIEWER_TOKEN):
            answer = server.page().request(method, filled(path), headers={"authorization": f"Bearer {token}"})
            assert (answer.status_code != 401) == any(TOKEN in way for way in security), (method, path)


def test_who_is_described_is_whom_the_route_obeys() -> None:
    said = {(method, path): way[SESSION] for method, path, ways in described() for way in ways if SESSION in way}
    for route, needed in NEEDS.items():
        if route in said:
            assert said[route] == ["viewer" if needed == "anyone" else needed], route
    assert len(said.keys() & NEEDS.keys()) == len(NEEDS) - 1, "all but to sign in"


def test_the_server_describes_the_cookie_that_it_gives(server: TestServer) -> None:
    page = server.page().sign_in()
    schema: dict[str, Any] = page.get("/api/openapi.json").json()
    assert schema["components"]["securitySchemes"][SESSION]["name"] == next(iter(page.cookies))
    assert server.services.sessions.cookie == f"tendril_test_{server.settings.port}" in page.cookies
    assert {"Hello", "Problem"} <= set(schema["components"]["schemas"])
