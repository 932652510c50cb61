"""What a webhook is told."""

from datetime import datetime
from typing import Literal

from controller.schema.layout import Model
from server.runs.messages import RunResult


class Notice(Model):
    """Body of the POST, as JSON. It holds no token, and nothing by which one could sign in."""

    event: Literal["fault", "e_stop", "run_end"]
    rig: str
    time: datetime
    """UTC."""
    text: str
    """One sentence for people."""
    cause: str
    """Why the rig is in FAULT or E-STOP, or why the run ended; "" where nothing is to be said."""
    run: RunResult | None = None
    """What came of the run; null for anything else."""
