"""What is asked for by a name that no one gave; the planner raises it, so nothing of the web framework is imported."""

from server.http.errors import NotFound


class UnknownReference(NotFound):
    """There is no reference of this name."""


class UnknownDrawing(UnknownReference):
    """There is no drawing of this name, or none that can be read."""
