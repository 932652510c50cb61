"""A CSV file that was sent rather than stored, as a recording."""

from collections.abc import Mapping
from pathlib import Path

from controller.reference.path_file import samples_in
from controller.tables.lines import sent_lines
from recordings.format.messages import Recording
from recordings.importing.tip import import_tip

SENT = "the file"
"""What errors call it."""


def import_text(folder: Path, name: str, text: bytes, units: Mapping[str, str]) -> tuple[Recording, tuple[str, ...]]:
    """As `read_samples` and `import_tip`, and what the file left open; DataError names line, column and value."""
    samples = samples_in(sent_lines(text, SENT), Path(SENT), units)
    return import_tip(folder, name, samples), samples.notes
