"""What each route asks for, as the OpenAPI says it: read off the gate, the roles and the routes themselves.

Every scheme comes with who may use it so, as OpenAPI 3.1 has it for schemes without scopes: `viewer` (who signed in
with either token), `operator` (with the operator's, or who was handed the lease), or `lease` (who operates now).
"""

from collections.abc import Iterator
from typing import Any, Literal

from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute
from starlette.routing import BaseRoute

from server.access.gate import FIGURES, is_open
from server.access.light import walk
from server.access.permit import holder
from server.access.roles import READING, VIEWERS
from server.access.sessions import cookie_name
from server.settings import ServerSettings

Needs = Literal["viewer", "operator", "lease"]
Security = list[dict[str, list[str]]]

SESSION, TOKEN = "session", "token"


def schemes(cookie: str) -> dict[str, dict[str, str]]:
    """The ways in that there are; `cookie` is the name under which this server keeps sessions."""
    about = "What POST /api/session gives for an access token; its name has the rig's and the port."
    return {
        SESSION: {"type": "apiKey", "in": "cookie", "name": cookie, "description": about},
        TOKEN: {"type": "http", "scheme": "bearer", "description": "An access token itself, of either role."},
    }


def secure(schema: dict[str, Any], routes: list[BaseRoute]) -> None:
    """Declare the ways in with the OpenAPI `schema`, and with each operation those that open it, if it is closed."""
    schema["components"]["securitySchemes"] = schemes(cookie_name(_field("rig"), _field("port")))
    for route in api_routes(routes):
        for method in (route.methods or ()) if route.include_in_schema else ():
            if security := security_of(method, route):
                schema["paths"][route.path_format][method.lower()]["security"] = security


def _field(name: str) -> Any:
    """What a server has without being told."""
    return ServerSettings.model_fields[name].default


def api_routes(routes: list[BaseRoute]) -> Iterator[APIRoute]:
    """Those of included routers, too."""
    return (route for route in walk(routes) if isinstance(route, APIRoute))


def security_of(method: str, route: APIRoute) -> Security:
    """The ways in, each of them enough; empty where anyone may, and with an empty one where some may without."""
    if is_open(route.path, method, "192.0.2.1"):
        return []
    nothing: Security = [{}] if is_open(route.path, method, "127.0.0.1") else []
    token: Security = [{TOKEN: ["viewer"]}] if route.path == FIGURES else []
    return [*nothing, {SESSION: [needs(method, route)]}, *token]


def needs(method: str, route: APIRoute) -> Needs:
    """The least with which the route does anything at all."""
    if _asks_for_lease(route.dependant):
        return "lease"
    return "viewer" if method in READING or route.name in VIEWERS else "operator"


def _asks_for_lease(dependant: Dependant) -> bool:
    return dependant.call is holder or any(map(_asks_for_lease, dependant.dependencies))
