"""The live scene, common to all: the rig's actuator as it is now, and the gizmo.

Viser itself has no rights and moves nothing: what the gizmo's drag means for the rig is decided in drag.py, from
messages that the proxy has read and attributed to a session.
"""

import contextlib
import io
import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
import viser

from controller.arrays import Array, Rows
from controller.schema.actuator import Actuator
from controller.schema.modes import Mode
from controller.schema.states import MOVING
from controller.system.thread import SupervisedThread
from server.http.given import given
from server.http.who import Identity
from server.scene.body import Body, moved
from server.scene.camera import Camera, camera_of
from server.scene.messages import View
from server.scene.playback import TRAIL
from server.scene.view_session import GROUND, ViewSession, ViewSessions

log = logging.getLogger(__name__)

GIZMO = "/live/target"
"""The gizmo's name in the scene."""
Point = tuple[float, float]
RATE = 30.0
LAST = 5.0
"""Longest wait for the update that is under way at the end [s]."""
STILL_S = 0.2
"""What has not moved is shown as it is this often, so that drift and the trail do not wait for a move."""
TRAIL_STEP = 5e-4
"""Way of the tip after which the trail grows [m]."""


class Gizmo:
    """A handle in the plane, the only thing in viser that a session may drag; drag.py decides what that means."""

    def __init__(self, scene: viser.SceneApi, at: Point) -> None:
        self._controls = scene.add_transform_controls(
            GIZMO,
            scale=0.1,
            active_axes=(True, True, False),
            disable_axes=True,
            disable_rotations=True,
            depth_test=False,
            position=(*at, 0.0),
        )

    def place(self, at: Point, again: bool) -> None:
        """Move it; `again` sends the pose even where the server believes it is there already."""
        if again:
            self._controls.position = (at[0], at[1], 1e-6)
        self._controls.position = (at[0], at[1], 0.0)


def gizmo_point(row: Any) -> Point:
    """Where the gizmo belongs: on the target while following, else where a drag would start, on the tip."""
    mode = int(row["mode"])
    field = "target" if mode in MOVING else "p_ref" if mode == Mode.HOLD else "p_hat"
    x, y = float(row[field][0]), float(row[field][1])
    return (x, y) if np.isfinite(x + y) else (0.0, 0.0)


class Scene:
    """Viser on a free port of 127.0.0.1, updated at 30 Hz while anyone looks and anything moves."""

    def __init__(
        self, newest: Callable[[], Rows | None], actuator: Callable[[], Actuator], light: bool = False
    ) -> None:
        """`light` leaves out what software rendering is slow at."""
        self._newest, self._wanted = newest, actuator
        with contextlib.redirect_stdout(io.StringIO()):  # its banner names an address that no one should open
            self._viser = viser.ViserServer(host="127.0.0.1", port=0, label="Tendril", verbose=False)
        # Any client may ask for a public tunnel; there is none to be had.
        setattr(self._viser, "request_share_url", lambda *_, **__: None)  # noqa: B010
        logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
        self._dragged, self._dirty = threading.Event(), threading.Event()
        self._sessions, self._entering = ViewSessions(light), dict[int, ViewSession]()
        self._trail: deque[tuple[float, Point]] = deque(maxlen=round(TRAIL * RATE))
        self._shown: Any = None
        self._shown_at = -math.inf
        self._logged = set[type[Exception]]()
        self._furnish()
        self._build(actuator())
        self._viser.on_client_connect(self._attach)
        self._viser.on_client_disconnect(self._leave)
        self.worker = SupervisedThread("scene", self._run)
        self.worker.start()

    @property
    def port(self) -> int:
        """Port that viser listens on."""
        return int(self._viser.get_port())

    def camera(self, view: View) -> Camera:
        """Where the camera stands in this view of the rig's actuator."""
        return camera_of(view, self._actuator.length)

    def view_session(self, id: str, who: Identity) -> ViewSession:
        """The view session `id` of `who`, new when there is none; NotAllowed when it is someone else's."""
        return self._sessions.take(id, who, self._actuator)

    def expect(self, port: int, session: ViewSession) -> None:
        """The client of viser that comes from this local port belongs to `session`."""
        self._entering[port] = session

    def gone(self, port: int) -> None:
        """The connection from this local port is closed."""
        self._entering.pop(port, None)

    def hold_gizmo(self, dragged: bool) -> None:
        """While the operator drags, the gizmo is theirs; else it follows the rig."""
        (self._dragged.set if dragged else self._dragged.clear)()
        self._dirty.set()

    def put_back(self) -> None:
        """Someone without the lease moved the gizmo in their own page: show again where it really is."""
        self._dirty.set()

    def gizmo(self) -> Point | None:
        """Where the gizmo is shown, as the rig has it."""
        newest = self._newest()
        return None if newest is None else gizmo_point(newest[0])

    def close(self) -> None:
        """Stop updating and close viser."""
        self.worker.stop(LAST)
        with contextlib.redirect_stdout(io.StringIO()):
            self._viser.stop()

    def _furnish(self) -> None:
        gui, scene = self._viser.gui, self._viser.scene
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        scene.set_background_image(np.full((1, 1, 3), GROUND["dark"], np.uint8), format="png")
        # Viser's own light washes the colours out, and colours are roles here.
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map(None)
        scene.add_light_ambient("/light/ambient", intensity=1.7)
        scene.add_light_directional("/light/sun", intensity=2.0, position=(-1.0, -2.0, 2.0))

    def _build(self, actuator: Actuator) -> None:
        self._actuator = actuator
        self._body = Body(self._viser.scene, "/live", actuator)
        self._gizmo = Gizmo(self._viser.scene, (actuator.length, 0.0))
        top, view = self.camera("top"), self._viser.initial_camera
        view.position, view.look_at, view.up, view.fov = top.position, top.look_at, top.up, top.fov

    def _run(self) -> None:
        while not self.worker.wait(1 / RATE):
            try:
                self._refresh(time.monotonic())
                for session in self._sessions:
                    session.refresh()
            except Exception as error:  # the view must come back after any surprise in one row
                if type(error) not in self._logged:  # there are 30 a second
                    log.exception("the 3D view could not be updated")
                self._logged.add(type(error))

    def _refresh(self, now: float) -> None:
        """Show the newest row if it looks other than the one on view, or that has been there for a while."""
        newest = self._newest()
        if newest is None or not self._viser.get_clients():
            return
        if self._wanted() != self._actuator:
            self._rebuild()
        row, dirty = newest[0], self._dirty.is_set()
        if not dirty and now - self._shown_at < STILL_S and not moved(row, self._shown):
            return
        self._shown, self._shown_at = row.copy(), now
        self._dirty.clear()
        with self._viser.atomic():
            self._body.update(row, self._grown_trail(row))
            if not self._dragged.is_set():
                self._gizmo.place(gizmo_point(row), again=dirty)

    def _grown_trail(self, row: Any) -> Array:
        """Where the measured tip was in the last seconds, (n,2) [m]."""
        now, tip = time.monotonic(), (float(row["p_meas"][0]), float(row["p_meas"][1]))
        last = self._trail[-1][1] if self._trail else (np.inf, np.inf)
        if np.isfinite(tip).all() and np.hypot(tip[0] - last[0], tip[1] - last[1]) >= TRAIL_STEP:
            self._trail.append((now, tip))
        while self._trail and now - self._trail[0][0] > TRAIL:
            self._trail.popleft()
        return np.array([point for _, point in self._trail]).reshape(-1, 2)

    def _rebuild(self) -> None:
        """The rig that answers now has another actuator."""
        self._body.remove()
        self._trail.clear()
        self._shown_at = -math.inf
        self._build(self._wanted())
        for session in self._sessions:
            session.meet(self._actuator)

    def _attach(self, client: Any) -> None:
        session = self._entering.get(self._local_port(client))
        if session is not None:
            session.attach(client)

    def _leave(self, client: Any) -> None:
        for session in self._sessions:
            session.leave(client)

    def _local_port(self, client: Any) -> int:
        """Port from which this client's connection comes: viser keeps it, but offers no way to ask."""
        connection = self._viser._websock_server._live_connections.get(client.client_id)
        return int(connection.remote_address[1]) if connection is not None else 0


GivenScene = Annotated[Scene, given(Scene)]
