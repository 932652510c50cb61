"""A view session: what one frame that shows the 3D view has for itself. No one else sees it, so it needs no lease."""

import threading
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from controller.arrays import Array
from controller.errors import NotAllowed
from controller.schema.actuator import Actuator
from server.http.who import Identity
from server.scene.body import above
from server.scene.camera import camera_of
from server.scene.lines import Paths
from server.scene.messages import Role, Scheme, View
from server.scene.playback import Player, Screen

GROUND: dict[Scheme, tuple[int, int, int]] = {"dark": (22, 24, 27), "light": (255, 255, 255)}
"""The page's own paper."""
GRID: dict[Scheme, tuple[int, int]] = {"dark": (46, 74), "light": (232, 206)}
"""Grey of fine and coarse lines."""


class ViewSession:
    """Wishes are kept here, and put into the scene of viser's client when there is one (or another: it reconnects)."""

    def __init__(self, who: Identity, actuator: Actuator, plain: bool) -> None:
        self.who, self._plain = who, plain
        self.scheme: Scheme = "dark"
        self.player: Player | None = None
        self._actuator = actuator
        self._wished: dict[Role, Sequence[Array]] = {}
        self._client: Any = None
        self._paths: Paths | None = None
        self._screen: Screen | None = None
        self._lock = threading.RLock()

    @property
    def taken(self) -> bool:
        """Whether a client of viser is attached."""
        return self._client is not None

    def attach(self, client: Any) -> None:
        """Show this client of viser everything that was wished so far."""
        with self._lock:
            self._client, self._screen = client, None
            self._furnish()
            self._lay_paths()

    def leave(self, client: Any) -> None:
        """Forget this client: it is gone."""
        with self._lock:
            if self._client is client:
                self._client = self._paths = self._screen = None

    def look(self, scheme: Scheme, view: View | None) -> None:
        """Ground of this colour scheme; camera to `view`, None leaves it."""
        with self._lock:
            changed, self.scheme = scheme != self.scheme, scheme
            if self._client is None:
                return
            if changed:
                self._furnish()
            if view is not None:
                with self._client.atomic():
                    camera_of(view, self._actuator.length).aim(self._client.camera)

    def show_path(self, role: Role, lines: Sequence[Array]) -> None:
        """Show lines through points (n,2) [m] in this role; none of them: nothing."""
        with self._lock:
            self._wished[role] = lines
            if self._paths is not None:
                self._paths.show(role, lines)

    def meet(self, actuator: Actuator) -> None:
        """The rig has another actuator."""
        with self._lock:
            self._actuator = actuator
            if self._client is not None:
                self._furnish()
                self._lay_paths()

    def play(self, player: Player | None) -> None:
        """Show a recording in the place of the live scene; None: live again."""
        with self._lock:
            if self._screen is not None:
                self._screen.remove()
            self.player, self._screen = player, None

    def refresh(self) -> None:
        """Called at the scene's rate: move what is played."""
        with self._lock:
            if self.player is None or self._client is None:
                return
            with self._client.atomic():
                if self._screen is None:
                    self._screen = Screen(self._client.scene, self.player)
                self._screen.refresh()

    def _furnish(self) -> None:
        scene = self._client.scene
        scene.set_background_image(np.full((1, 1, 3), GROUND[self.scheme], np.uint8), format="png")
        if not self._plain:
            _grid(scene, self._actuator, self.scheme)

    def _lay_paths(self) -> None:
        if self._paths is not None:
            for role in self._wished:
                self._paths.show(role, [])
        self._paths = Paths(self._client.scene, above(self._actuator))
        for role, lines in self._wished.items():
            self._paths.show(role, lines)


class ViewSessions:
    """All view sessions; those that had no client for longest go first."""

    SESSIONS_MAX = 64

    def __init__(self, plain: bool) -> None:
        self._plain = plain
        self._sessions: dict[str, ViewSession] = {}
        self._lock = threading.Lock()

    def __iter__(self) -> Iterator[ViewSession]:
        with self._lock:
            return iter(list(self._sessions.values()))

    def take(self, id: str, who: Identity, actuator: Actuator) -> ViewSession:
        """The view session `id` of `who`, new when there is none; NotAllowed when it is someone else's."""
        with self._lock:
            session = self._sessions.pop(id, None) or ViewSession(who, actuator, self._plain)
            self._sessions[id] = session
            for old in [key for key, found in self._sessions.items() if not found.taken][: -self.SESSIONS_MAX]:
                del self._sessions[old]
        if not session.who.is_session(who):
            raise NotAllowed("this 3D view belongs to another page")
        return session


def _grid(scene: Any, actuator: Actuator, scheme: Scheme) -> None:
    fine, coarse = GRID[scheme]
    scene.add_grid(
        "/ground",
        width=8 * actuator.length,
        height=8 * actuator.length,
        cell_size=0.05,
        section_size=0.25,
        cell_color=(fine,) * 3,
        section_color=(coarse,) * 3,
        position=(0.0, 0.0, -actuator.height / 2 - 1e-3),
    )
