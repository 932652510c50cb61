"""The twin's time can stand still between two ticks, and go on by single ticks. Hardware has no such time."""

import time

from controller.realtime.ring import PAUSED, STEPPED, STEPS, Ring
from controller.schema.messages import TwinTime

UNHEARD_S = 2.0
"""Silence of all servers after which time goes on: the watchdogs of the loop then see to the rest."""


class Pause:
    """Writes the loop's words for it. `put` is called with a lock held; `end` needs none."""

    def __init__(self, ring: Ring) -> None:
        self._ring = ring
        self._heard = time.monotonic()

    @property
    def on(self) -> bool:
        """Whether time stands still, or goes on by steps."""
        return bool(self._ring.header[PAUSED])

    @property
    def rests(self) -> bool:
        """Whether no row comes: all steps are taken."""
        return self.on and self._left() == 0

    def put(self, wanted: TwinTime) -> None:
        """Let time stand still or go on; ticks that were still to be taken are replaced by those of `wanted`."""
        self._ring.header[STEPS] = self._ring.header[STEPPED] + (wanted.steps if wanted.paused else 0)
        self._ring.header[PAUSED] = int(wanted.paused)

    def end(self) -> None:
        """Let time go on, as it must before the loop can act."""
        self._ring.header[PAUSED] = 0

    def state(self) -> TwinTime:
        """As it is now."""
        return TwinTime(paused=self.on, steps=self._left() if self.on else 0)

    def hear(self) -> None:
        """A server commands."""
        self._heard = time.monotonic()

    def look(self) -> None:
        """End it where no server has commanded for UNHEARD_S."""
        if self.on and time.monotonic() - self._heard > UNHEARD_S:
            self.end()

    def _left(self) -> int:
        return max(0, int(self._ring.header[STEPS] - self._ring.header[STEPPED]))
