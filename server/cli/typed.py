"""What all groups of commands have in common."""

from pathlib import Path
from typing import Annotated, Any

import typer

RecordingsFolder = Annotated[
    Path | None,
    typer.Option(
        "--recordings",
        "--folder",
        envvar="TENDRIL_RECORDINGS",
        help="Folder of the recordings; the server's own without it.",
    ),
]

Comments = Annotated[bool, typer.Option("--comments", help="Begin a CSV file with its origin, as lines with #.")]


def commands(**more: Any) -> typer.Typer:
    """A group of commands. Its help is Markdown, in which a unit in brackets stays as it is."""
    return typer.Typer(rich_markup_mode="markdown", **more)
