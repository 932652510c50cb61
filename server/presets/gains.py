"""Presets of gains, in one file of the state folder."""

from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from controller.errors import CommandRefused, TendrilError
from controller.parameters import Settings
from server.presets.messages import GainPreset
from server.settings import write_private

MOST = 100
"""Presets that are kept; a new one beyond is refused."""
_FILE: TypeAdapter[list[GainPreset]] = TypeAdapter(list[GainPreset])


class GainPresets:
    """The presets in `path`, by name."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def listed(self) -> list[GainPreset]:
        """All of them, by name; TendrilError when the file is damaged."""
        if not self._path.exists():
            return []
        try:
            return _FILE.validate_json(self._path.read_bytes())
        except ValidationError as error:
            raise TendrilError(f"{self._path} is damaged: delete it, and save the presets anew") from error

    def save(self, name: str, settings: Settings) -> list[GainPreset]:
        """Keep `settings` under `name`, in place of what was there; returns all."""
        others = [preset for preset in self.listed() if preset.name != name]
        if len(others) >= MOST:
            raise CommandRefused(f"there are {MOST} presets already: delete one first")
        return self._write([*others, GainPreset(name=name, settings=settings)])

    def delete(self, name: str) -> list[GainPreset]:
        """Forget the preset; returns the others."""
        return self._write([preset for preset in self.listed() if preset.name != name])

    def _write(self, presets: list[GainPreset]) -> list[GainPreset]:
        presets = sorted(presets, key=lambda preset: preset.name.lower())
        try:
            write_private(self._path, _FILE.dump_json(presets, indent=1).decode())
        except OSError as error:
            raise TendrilError(f"the presets cannot be saved: {error.strerror}") from error
        return presets
