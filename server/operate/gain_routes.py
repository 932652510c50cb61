"""Presets of gains."""

import asyncio

from fastapi import APIRouter

from server.access.asking import Holder
from server.http.given import GivenSettings
from server.log.events import GivenEvents
from server.operate.gains import GainPresets
from server.operate.messages import GainPreset, PresetName
from server.operate.operator import GivenOperator
from server.operate.settings import GivenKeptSettings
from server.settings import ServerSettings

router = APIRouter(tags=["presets"])


@router.get("/api/gains")
async def read_gains(settings: GivenSettings) -> list[GainPreset]:
    """The saved presets, by name."""
    return _presets(settings).listed()


@router.put("/api/gains/{name}")
async def save_gains(
    name: PresetName,
    kept: GivenKeptSettings,
    settings: GivenSettings,
    operator: GivenOperator,
    who: Holder,
    events: GivenEvents,
) -> list[GainPreset]:
    """Save the settings in force under this name; all presets."""
    async with kept.changing:
        found = await asyncio.to_thread(_presets(settings).save, name, operator.settings)
    events.add(f"{who.name}: gains saved as {name!r}")
    return found


@router.delete("/api/gains/{name}")
async def delete_gains(
    name: PresetName, kept: GivenKeptSettings, settings: GivenSettings, who: Holder
) -> list[GainPreset]:
    """Delete a preset; the ones that are left."""
    async with kept.changing:
        return await asyncio.to_thread(_presets(settings).delete, name)


def _presets(settings: ServerSettings) -> GainPresets:
    return GainPresets(settings.state / "gains.json")
