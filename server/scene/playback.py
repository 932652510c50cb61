"""A recording in one 3D view: the server's clock says which row is on view, so that a slow page skips, never lags."""

import time
from collections.abc import Callable

import viser

from recordings.read.playback import PlaybackRows
from server.scene.body import Body
from server.scene.messages import Playback, PlaybackBody

TRAIL = 2.0
"""Seconds of the tip that are drawn."""
ROOT = "/played"


class Player:
    """Plays the recording `id`; `now` is the server's clock [s]."""

    def __init__(self, id: str, playback: PlaybackRows, now: Callable[[], float] = time.monotonic) -> None:
        self.id, self.playback = id, playback
        self._now = now
        self._start, self._from, self._rate, self._playing = now(), 0.0, 1.0, False

    def control(self, body: PlaybackBody) -> None:
        """Go to a time, and play or stand from there."""
        self._start, self._from = self._now(), min(body.at, self.playback.duration)
        self._rate, self._playing = body.rate, body.playing

    @property
    def at(self) -> float:
        """Time in the recording [s]."""
        gone = (self._now() - self._start) * self._rate if self._playing else 0.0
        return min(self._from + gone, self.playback.duration)

    def state(self) -> Playback:
        """What the page shows of it; at the end it stands."""
        at, duration = self.at, self.playback.duration
        playing = self._playing and at < duration
        return Playback(recording=self.id, at=at, duration=duration, playing=playing, rate=self._rate)


class Screen:
    """A player's body in the scene of one client, in the place of the live one."""

    def __init__(self, scene: viser.SceneApi, player: Player) -> None:
        self._player = player
        # viser: a client's own node stands for the common one of the same name, with all that is below it.
        self._curtain = scene.add_frame("/live", show_axes=False, visible=False)
        self._body = Body(scene, ROOT, player.playback.actuator)
        self._shown = -1.0

    def refresh(self) -> None:
        """Show what the clock says."""
        at = self._player.at
        if at != self._shown:
            self._shown = at
            self._body.update(self._player.playback.row(at), self._player.playback.trail(at, TRAIL))

    def remove(self) -> None:
        """Back to the live scene."""
        self._body.remove()
        self._curtain.remove()
