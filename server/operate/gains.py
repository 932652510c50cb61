"""Presets of gains, in one file of the state folder."""

import asyncio
from pathlib import Path

from fastapi import APIRouter
from pydantic import TypeAdapter

from controller.errors import CommandRefused, TendrilError
from controller.schema.parameters import REPEATING, Settings
from controller.system.state_file import StateFile
from server.access.permit import Holder
from server.http.errors import NotFound
from server.http.given import GivenSettings
from server.log.events import GivenEvents
from server.operate.messages import GainPreset, PresetName, SettingsBody
from server.operate.operator import GivenOperator
from server.operate.settings import GivenKeptSettings
from server.settings import ServerSettings

PRESETS_MAX = 100
"""Presets that are kept; a new one beyond is refused."""
BUILT_IN = GainPreset(name="Paths that repeat", settings=REPEATING, built_in=True)
LOADED = {"K_P", "K_I", "K_FF", "K_o", "B_o", "law", "feedforward_period", "speed_max", "acceleration_max"}
"""What is loaded from a preset; the choice of sensors and the open-loop command stay, as in the page's `gainsOf`."""
_FILE: TypeAdapter[list[GainPreset]] = TypeAdapter(list[GainPreset])


class GainPresets:
    """The presets in `path`, by name."""

    def __init__(self, path: Path) -> None:
        self._file = StateFile(path, _FILE.validate_json, "the saved presets of gains are missing")

    def listed(self) -> list[GainPreset]:
        """Ours, then the saved ones by name; ours alone when the file cannot be used."""
        return [BUILT_IN, *self._saved()]

    def _saved(self) -> list[GainPreset]:
        return self._file.read() or []

    def save(self, name: str, settings: Settings) -> list[GainPreset]:
        """Keep `settings` under `name`, in place of what was there; returns all."""
        others = self._others(name)
        if len(others) >= PRESETS_MAX:
            raise CommandRefused(f"there are {PRESETS_MAX} presets already: delete one first")
        return self._write([*others, GainPreset(name=name, settings=settings)])

    def changes(self, name: str) -> SettingsBody:
        """What it changes to load this preset; NotFound when there is none."""
        found = next((preset for preset in self.listed() if preset.name == name), None)
        if found is None:
            raise NotFound(f"there is no preset of gains named {name}")
        return SettingsBody(changes=found.settings.model_dump(mode="json", include=LOADED))

    def delete(self, name: str) -> list[GainPreset]:
        """Forget the preset; returns the others."""
        return self._write(self._others(name))

    def _others(self, name: str) -> list[GainPreset]:
        if name == BUILT_IN.name:
            raise CommandRefused(f"{name!r} comes with Tendril: take another name")
        return [preset for preset in self._saved() if preset.name != name]

    def _write(self, presets: list[GainPreset]) -> list[GainPreset]:
        presets = sorted(presets, key=lambda preset: preset.name.lower())
        try:
            self._file.write(_FILE.dump_json(presets, indent=1))
        except OSError as error:
            raise TendrilError(f"the presets cannot be saved: {error.strerror}") from error
        return [BUILT_IN, *presets]


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
