"""The campaign floods every route that a viewer may ask, and what it asks costs the server what it can cost."""

from starlette.routing import Route

from server.access.light import walk
from server.access.roles import READING, VIEWERS
from server.app.app import openapi_schema
from server.campaign.flood import WITHOUT_ROUTE, viewer_floods
from server.campaign.viewer import BODIES, SPARED, Asked, asked
from tests.server.live_server import VIEWER_TOKEN, Page, TestServer

ASKED = asked(openapi_schema(), "none")
SIGN_IN = "sign_in_by_token"
"""Has a flood of its own."""
ABSENT = (404, 409)
"""Answers where a recording, an export or a 3D view is not there."""
MALFORMED = 422


def test_every_route_that_a_viewer_may_ask_is_flooded(server: TestServer) -> None:
    for route in walk(server.app.routes):
        if isinstance(route, Route) and route.name not in (*SPARED, SIGN_IN):
            for method in (route.methods or set()) - {"HEAD", "OPTIONS"}:
                if method in READING or route.name in VIEWERS:
                    assert any(takes(route, method, one) for one in ASKED), (method, route.path)


def takes(route: Route, method: str, one: Asked) -> bool:
    return one.method == method and route.path_regex.match(one.path.partition("?")[0]) is not None


def test_nothing_that_is_asked_is_refused_as_it_is_written(server: TestServer) -> None:
    page = server.page().sign_in(VIEWER_TOKEN)
    for one in ASKED:
        code = answered(page, one)
        assert code < 400 or code in ABSENT or (code == MALFORMED and one.body == {}), (one, code)


def answered(page: Page, one: Asked) -> int:
    if isinstance(one.body, str):
        return page.request(one.method, one.path, content=one.body).status_code
    return page.request(one.method, one.path, json=one.body).status_code


def test_each_flood_has_a_name_of_its_own_and_each_body_an_operation() -> None:
    names = viewer_floods("none")
    assert len(set(names)) == len(names) == len(ASKED) + len(WITHOUT_ROUTE)
    operations = {one["operationId"] for methods in openapi_schema()["paths"].values() for one in methods.values()}
    assert operations.issuperset(BODIES)
