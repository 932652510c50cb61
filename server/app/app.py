"""The application: routes, sockets, gate and error answers around the services it is given."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from enum import IntEnum
from functools import cache
from typing import Any

from fastapi import Depends, FastAPI, Request
from fastapi.responses import JSONResponse
from starlette.datastructures import State

from controller.errors import ProcessKilled
from controller.schema.modes import Cause, Freeze, Integrator, Law, Mode
from controller.system.origin import our_version
from recordings.exporting import export
from server.access import page, sign_in
from server.access.gate import Gate, Hosts
from server.access.light import RouteRates
from server.access.roles import authorise
from server.access.security import schemes, secure
from server.access.sessions import Sessions
from server.app.services import Services
from server.drawing import planning
from server.drawing import routes as drawing
from server.hardware import routes as hardware
from server.hardware.commissioning import routes as commissioning
from server.health import routes as health
from server.http import given, problems
from server.http.answers import REFUSALS, say_once
from server.live import presence, socket
from server.live.messages import FromBrowser, FromServer, Heard
from server.log.events import note_refusal
from server.operate import command_routes, gains, lease_routes, settings
from server.operate.messages import Presence
from server.plots import routes as plots
from server.recorder import export_routes, rerun_routes
from server.recorder import routes as recorder
from server.rig import reach, twin_routes
from server.rig import routes as rig
from server.runs import recorded_path
from server.runs import routes as runs
from server.runs.macros import routes as macros
from server.scene import proxy
from server.scene import routes as scene

ROUTES = (
    command_routes,  # these two are found first: an E-STOP comes by them
    socket,
    sign_in,
    lease_routes,
    settings,
    rig,
    health,
    drawing,
    runs,
    recorded_path,
    macros,
    recorder,
    export_routes,
    plots,
    gains,
    hardware,
    commissioning,
    presence,
    page,
    rerun_routes,
    twin_routes,
    scene,
    proxy,
)
"""Every room's routes: a new room adds a line."""
_ENUMERATIONS: tuple[type[IntEnum], ...] = (Cause, Freeze, Integrator, Law, Mode)


NOWHERE = {"type": "http", "method": "GET", "path": "/-", "root_path": "", "headers": []}
"""What no route takes, and all look at."""
MEETING = 0.1
"""Between two looks for the rig [s]."""
THREADS = 32
"""For what requests ask of disks and processors. Where a disk hangs each that asks for it keeps one; commands to the
rig, uploads of runs and the jobs of the event loop need none."""


class Api(FastAPI):
    """FastAPI whose OpenAPI names the members of our enumerations, says each refusal once, and who is let in."""

    def openapi(self) -> dict[str, Any]:
        """The description from which the page's types are made."""
        schema = super().openapi()
        for kind in _ENUMERATIONS:
            described = schema["components"]["schemas"].get(kind.__name__)
            if described is not None:
                described["x-enum-varnames"] = [member.name for member in kind]
        say_once(schema)
        secure(schema, self.routes)
        return schema


def create_app(services: Services) -> FastAPI:
    """The ASGI application. It closes `services` when it shuts down."""
    app = copy(_api())
    app.state, app.user_middleware = State({"services": services}), []
    given.give(app, services.by_class())
    app.add_middleware(
        Gate,
        sessions=services.sessions,
        hosts=Hosts(services.settings),
        rates=RouteRates(services.rates, app.routes),
        audit=services.audit,
        refused=services.refused,
    )
    return app


def openapi_schema() -> dict[str, Any]:
    """The OpenAPI description, socket messages included; needs no rig and no settings."""
    return _api().openapi()


@cache
def _api() -> FastAPI:
    """The routes, the same for all services, and at once what FastAPI would make of them when first asked.

    That takes half a second and more: it would hold up the event loop in the middle of whatever is asked then.
    """
    app = Api(
        title="Tendril",
        version=our_version(),
        openapi_url=None,  # its own route would be without this server's cookie
        docs_url=None,
        redoc_url=None,
        lifespan=_lifespan,
        responses=REFUSALS,
        generate_unique_id_function=lambda route: route.name,
    )
    problems.install(app, note_refusal)
    for part in ROUTES:
        app.include_router(part.router, dependencies=[Depends(authorise)])
    app.add_route("/api/openapi.json", _described, include_in_schema=False)
    page.mount_assets(app)
    app.webhooks.post("live")(live_messages)
    app.webhooks.post("presence")(presence_messages)
    for route in app.routes:
        route.matches(NOWHERE)
    return app


def _described(request: Request) -> JSONResponse:
    """The OpenAPI with the name that this server's cookie has."""
    schema = openapi_schema()
    ways = {"securitySchemes": schemes(given.part_of(request, Sessions).cookie)}
    return JSONResponse(schema | {"components": schema["components"] | ways})


async def live_messages(body: FromBrowser) -> FromServer:  # type: ignore[empty-body]
    """What the page says on /ws/live (request) and what it hears (response), as JSON text."""


async def presence_messages(body: Presence) -> Heard:  # type: ignore[empty-body]
    """What the page's worker says on /ws/presence (request) and what it hears (response), as JSON text."""


@contextlib.asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    services: Services = app.state.services
    services.scheduler.start()
    services.scheduler.begin("what every page asks for first", _prepare(services))
    services.scheduler.begin("what exports need", _prepare_reader(services))
    asyncio.get_running_loop().set_default_executor(ThreadPoolExecutor(THREADS, "request"))
    try:
        yield
    finally:
        await services.procedures.leave()
        services.scheduler.stop()
        await services.viser_files.close()
        await asyncio.to_thread(services.close)


async def _prepare(services: Services) -> None:
    """What every page asks for first is made when the rig is met."""
    while (info := services.rig.info) is None:
        await asyncio.sleep(MEETING)
    with contextlib.suppress(ProcessKilled):  # who asks for it hears that
        await services.planner.do(reach.workspace, info.parameters)
        await services.planner.do(planning.menu, info.parameters)


async def _prepare_reader(services: Services) -> None:
    with contextlib.suppress(ProcessKilled):  # as above
        await services.reader.do(export.warm_up)
