"""Which routes a session may ask for hundreds of times a second; all others are heavy, a new one too until it is here.

Light is what a page or a program at work asks for again and again, and what takes the server no more than routing, a
look at what it has in its memory, a word with the rig, or one small file: 1 to 3 ms of a core. Whatever plans, reads
recordings or the whole folder of them, makes a large answer, or fetches one from elsewhere is heavy.
"""

from collections.abc import Iterable, Iterator

from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.types import Scope

from server.http.rates import Rates, TooOften

WEBSOCKET = "WEBSOCKET"
LIGHT = frozenset(
    {
        # the page itself, and its sockets
        "page",
        "assets",
        "live",
        "presence",
        "may_look_on",
        # who one is, and who operates
        "sign_in_by_token",
        "read_session",
        "sign_out",
        "take_lease",
        "release_lease",
        "change_lease",
        "ask_for_lease",
        "withdraw_request",
        "refuse_request",
        "hand_over_lease",
        "take_over_lease",
        # the rig as it is now
        "command",
        "read_health",
        "read_loop_health",
        "read_settings",
        "change_settings",
        "rig_info",
        "read_drivers",
        "read_faults",
        "inject_faults",
        "read_time",
        "set_time",
        # runs, steps of commissioning, and a button that is held
        "pause_run",
        "resume_run",
        "stop_run",
        "read_runs",
        "stop_macro",
        "read_first_mode",
        "stop_first_mode",
        "read_commissioning",
        "stop_commissioning_step",
        "jog_chamber",
        "confirm_chamber",
        "capture_point",
        # names and small files
        "read_alarms",
        "read_gains",
        "read_layouts",
        "read_layout",
        "read_macros",
        "read_drawings",
        "read_drawing",
        "read_references",
        # one recording of many that are chosen together
        "recording",
        "edit_recording",
        "remove_recording",
        "restore_recording",
        "stop_recording",
        "set_bookmark",
        "name_bookmark",
        "remove_bookmark",
        # what a 3D view shows while one draws
        "change_look",
        "change_path",
    }
)
"""Names of the routes."""


class RouteRates:
    """Judges how often requests come, by the route that will take them."""

    def __init__(self, rates: Rates, routes: Iterable[BaseRoute]) -> None:
        self._rates = rates
        self._routes = [(_methods(route), route.path_regex, route.name in LIGHT) for route in walk(routes)]

    def refusal(self, scope: Scope, client: str | None, address: str) -> TooOften | None:
        """Why this request of `client`, None for a stranger at `address`, must wait; None if it need not."""
        return self._rates.refusal(client, address, self.is_light(scope))

    def is_light(self, scope: Scope) -> bool:
        """Whether the first route that takes this method and path is light; what no route takes is not."""
        method, path = str(scope.get("method", WEBSOCKET)), scope["path"]
        return next((light for methods, fits, light in self._routes if method in methods and fits.match(path)), False)


def walk(routes: Iterable[BaseRoute]) -> "Iterator[Route | WebSocketRoute | Mount]":
    """All of them in the order in which they are looked at, those of included routers, too."""
    for route in routes:
        if isinstance(route, Route | WebSocketRoute | Mount):
            yield route
        elif inner := getattr(route, "original_router", None):
            yield from walk(inner.routes)


def _methods(route: Route | WebSocketRoute | Mount) -> frozenset[str]:
    if isinstance(route, Route):
        return frozenset(route.methods or ())
    return frozenset({WEBSOCKET}) if isinstance(route, WebSocketRoute) else frozenset({"GET", "HEAD"})
