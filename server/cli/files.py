"""Files that a command writes: refused before the work if that is impossible, and one clear error if it fails."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from controller.errors import TendrilError

if TYPE_CHECKING:
    from controller.schema.origin import Origin


def require_file(path: Path) -> None:
    """Raise TendrilError unless a file could be written at `path`."""
    folder = path.absolute().parent
    if path.is_dir():
        raise TendrilError(f"{path} cannot be written: it is a folder")
    if not folder.is_dir():
        raise TendrilError(f"{path} cannot be written: its folder does not exist")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise TendrilError(f"{path} cannot be written: permission denied")


def made(folder: Path) -> Path:
    """`folder`, there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TendrilError(f"{folder} cannot be made: {error.strerror}") from error
    return folder


def write_json(path: Path, figures: Mapping[str, object], origin: "Origin") -> None:
    """Write `figures` and beside them, under `origin`, where they come from; TendrilError as `write`."""
    whole = {**figures, "origin": origin.model_dump(mode="json")}
    write(path, json.dumps(whole, indent=2) + "\n")


def write(path: Path, text: str) -> None:
    """Write `text` as UTF-8, or raise TendrilError."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise TendrilError(f"{path} cannot be written: {error.strerror}") from error
