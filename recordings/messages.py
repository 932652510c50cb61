"""What is said about recordings: the recorder's state and one row of the list."""

from datetime import datetime

from controller.layout import Model


class RecordingState(Model):
    """What the recorder does now."""

    recording: bool
    id: str
    seconds: float
    rows: int
    gaps: int
    """Ticks that are missing between the rows given: 0 when nothing was lost."""
    problem: str = ""
    """Why the last recording ended by itself (a full disk, ...), "" when it did not."""


class Recording(Model):
    """One row of the Review tab."""

    id: str
    name: str
    started: datetime
    seconds: float
    rows: int
    gaps: int
    bytes: int
    actuator: str
    twin: bool
    complete: bool
    """False: the writer was killed; the file is readable up to its last batch."""
    recovered: bool = False
    """The file of a killed writer was mended: it holds what was written, with a proper end."""
