"""Live settings: law, sensors, gains, limits."""

import asyncio

from fastapi import APIRouter
from pydantic import ValidationError

from controller.errors import CommandRefused
from controller.schema.parameters import Settings
from server.access.asking import Permitted
from server.http.problems import malformed
from server.log.events import GivenEvents
from server.operate.kept_settings import GivenKeptSettings
from server.operate.messages import SettingsBody
from server.operate.operator import GivenOperator

router = APIRouter(tags=["settings"])


@router.get("/api/settings")
async def read_settings(operator: GivenOperator) -> Settings:
    """The settings in force."""
    return operator.settings


@router.patch("/api/settings")
async def change_settings(
    body: SettingsBody, operator: GivenOperator, kept: GivenKeptSettings, permit: Permitted, events: GivenEvents
) -> Settings:
    """Change some settings; in force (and returned) only when the rig has taken them."""
    async with kept.changing:
        wanted = _merged(operator.settings, body)
        reply = await asyncio.wrap_future(operator.change(wanted, permit))
        if not reply.accepted:
            raise CommandRefused(reply.detail)
        await kept.keep(operator.settings)
    events.add(f"{permit.name}: {', '.join(f'{name} = {value}' for name, value in body.changes.items())}")
    return operator.settings


def _merged(before: Settings, body: SettingsBody) -> Settings:
    try:
        return Settings.model_validate({**before.model_dump(), **body.changes})
    except ValidationError as error:
        raise malformed(error, "body", "changes") from error
