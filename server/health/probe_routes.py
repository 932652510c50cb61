"""What a probe and Prometheus ask for."""

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST

from server.health.healthz import GivenProbed, Healthz, healthz
from server.health.metrics import GivenFigures, exposition
from server.http import answers

router = APIRouter(tags=["monitoring"])


@router.get("/healthz", responses={503: {"model": Healthz, "description": "Something is not well"}})
async def read_healthz(probed: GivenProbed, response: Response) -> Healthz:
    """Whether all is well, 503 when something is not; open to anyone on this machine."""
    found = await healthz(probed)
    response.status_code = 200 if found.ok else 503
    return found


@router.get("/metrics", response_class=Response, responses=answers.body("text/plain", "Prometheus' text format"))
async def read_metrics(figures: GivenFigures) -> Response:
    """Figures for Prometheus, with a session or `Authorization: Bearer ACCESS_TOKEN`."""
    return Response(exposition(figures), media_type=CONTENT_TYPE_LATEST)
