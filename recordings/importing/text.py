"""A CSV file that was sent rather than stored, as a recording."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

from controller.errors import DataError
from controller.reference.path_file import read_samples
from recordings.format.messages import Recording
from recordings.importing.tip import import_tip

SENT = "the file"
"""What errors call it."""


def import_text(folder: Path, name: str, text: bytes, units: Mapping[str, str]) -> Recording:
    """As `read_samples` and `import_tip`; DataError names line, column and value."""
    with tempfile.TemporaryDirectory(prefix="tendril-import-") as scratch:
        file = Path(scratch, SENT)
        file.write_bytes(text)
        try:
            return import_tip(folder, name, read_samples(file, units))
        except DataError as error:
            raise DataError(str(error).replace(f"{scratch}/", "")) from error
