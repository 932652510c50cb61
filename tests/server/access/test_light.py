"""Which requests are light: those of routes that are named, whatever else their path could mean."""

import pytest
from starlette.routing import Mount, Route, WebSocketRoute

from server.access.light import LIGHT, WEBSOCKET, RouteRates, walk
from tests.server.access.test_roles import filled
from tests.server.live_server import TestServer


@pytest.fixture
def light(server: TestServer) -> RouteRates:
    return RouteRates(server.services.rates, server.app.routes)


def scope(method: str, path: str) -> dict[str, object]:
    return {"type": "http", "method": method, "path": path}


def test_every_light_route_is_there_and_found_by_its_path_and_no_other_is(
    server: TestServer, light: RouteRates
) -> None:
    routes = [route for route in walk(server.app.routes) if not isinstance(route, Mount)]
    assert {route.name for route in walk(server.app.routes)} >= LIGHT
    for route in routes:
        for method in (route.methods or ()) if isinstance(route, Route) else [WEBSOCKET]:
            path = filled(route.path)
            assert light.is_light(scope(method, path)) == (route.name in LIGHT), (method, path)
    assert sum(isinstance(route, WebSocketRoute) for route in routes) > 3


@pytest.mark.parametrize(
    ("method", "path", "expected"),
    [
        ("GET", "/api/drawings/leaf", True),
        ("GET", "/api/drawings/leaf.csv", False),
        ("GET", "/viser/", False),
        ("GET", "/viser/seat/abcdefgh/", False),
        ("GET", "/api/openapi.json", False),
        ("GET", "/metrics", False),
        ("GET", "/assets/index-1a2b.js", True),
        ("GET", "/no/such/path", False),
        ("PUT", "/api/health", False),
        (WEBSOCKET, "/ws/live", True),
        (WEBSOCKET, "/viser", False),
    ],
)
def test_the_first_route_that_takes_a_request_decides(
    method: str, path: str, expected: bool, light: RouteRates
) -> None:
    assert light.is_light(scope(method, path)) == expected
