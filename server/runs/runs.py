"""The run under way: from what an operator asks for to the rig's TRACK and the result."""

from controller.errors import CommandRefused
from server.auth import Identity
from server.runs.messages import RunBody, RunResult, RunState


class Runs:
    """At most one run at a time. Only the event loop uses it."""

    async def start(self, body: RunBody, who: Identity) -> RunState:
        """Begin a run."""
        raise CommandRefused("runs are not possible yet")

    async def pause(self, who: Identity) -> RunState:
        """Hold, and remember where."""
        raise CommandRefused("no run is under way")

    async def resume(self, who: Identity) -> RunState:
        """Go on where it was paused."""
        raise CommandRefused("no run is paused")

    async def stop(self, who: Identity) -> RunState:
        """Hold, and end the run."""
        raise CommandRefused("no run is under way")

    def state(self) -> RunState | None:
        """The run under way, or how the last one ended; None before the first."""
        return None

    def results(self) -> list[RunResult]:
        """What came of the last runs, newest first."""
        return []
