"""Live settings: law, sensors, gains, limits."""

import asyncio

from fastapi import APIRouter
from pydantic import ValidationError

from controller.errors import CommandRefused
from controller.schema.parameters import Settings
from server.deps import Parts, Permitted
from server.messages import SettingsBody
from server.problems import malformed

router = APIRouter(tags=["settings"])


@router.get("/api/settings")
async def read_settings(parts: Parts) -> Settings:
    """The settings in force."""
    return parts.operator.settings


@router.patch("/api/settings")
async def change_settings(body: SettingsBody, parts: Parts, permit: Permitted) -> Settings:
    """Change some settings; in force (and returned) only when the rig has taken them."""
    async with parts.settings_lock:
        wanted = _merged(parts.operator.settings, body)
        reply = await asyncio.wrap_future(parts.operator.change(wanted, permit))
        if not reply.accepted:
            raise CommandRefused(reply.detail)
        await parts.keep_settings()
    parts.events.add(f"{permit.name}: {', '.join(f'{name} = {value}' for name, value in body.changes.items())}")
    return parts.operator.settings


def _merged(before: Settings, body: SettingsBody) -> Settings:
    try:
        return Settings.model_validate({**before.model_dump(), **body.changes})
    except ValidationError as error:
        raise malformed(error, "body", "changes") from error
