"""A line of the log on the wire."""

from datetime import datetime
from typing import Literal

from controller.schema.layout import Model


class Event(Model):
    """One line of the log: who did what, and what was refused."""

    type: Literal["event"] = "event"
    time: datetime
    level: Literal["info", "warning", "error"]
    text: str
