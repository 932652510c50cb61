"""The 3D view: viser shows the rods as bodies, the markers, the reference and the target, and offers a gizmo to drag.

Viser itself has no rights and moves nothing: what the gizmo's drag means for the rig is decided in drag.py, from
messages that the proxy has read and attributed to a session.
"""

import contextlib
import io
import logging
import threading
from collections.abc import Callable
from typing import Any
from urllib.parse import urlencode

import numpy as np
import viser

from controller.actuator import Actuator
from server.body import Body, Point, gizmo_point
from server.channels import Rows

log = logging.getLogger(__name__)

RATE = 30.0


class Scene:
    """Viser on a free port of 127.0.0.1, updated at 30 Hz while anyone looks."""

    def __init__(
        self, newest: Callable[[], Rows | None], actuator: Callable[[], Actuator], light: bool = False
    ) -> None:
        self._newest, self._wanted = newest, actuator
        with contextlib.redirect_stdout(io.StringIO()):  # its banner names an address that nobody should open
            self._viser = viser.ViserServer(host="127.0.0.1", port=0, label="Tendril", verbose=False)
        # Any client may ask for a public tunnel; there is none to be had.
        setattr(self._viser, "request_share_url", lambda *_, **__: None)  # noqa: B010
        logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
        self._light = light
        self._dragged, self._dirty, self._closed = threading.Event(), threading.Event(), threading.Event()
        self._furnish()
        self._actuator = actuator()
        self._body = Body(self._viser, self._actuator, light)
        self._aim_camera()
        self._thread = threading.Thread(target=self._run, name="scene", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Port that viser listens on."""
        return int(self._viser.get_port())

    def view_query(self, view: str) -> str | None:
        """Query string that makes viser's page start in the view "top" or "oblique"; None for any other name."""
        camera = _cameras(self._actuator.length).get(view)
        if camera is None:
            return None
        names = ("initialCameraPosition", "initialCameraLookAt", "initialCameraUp")
        words = {name: ",".join(f"{x:.4f}" for x in value) for name, value in zip(names, camera[:3], strict=True)}
        return urlencode({**words, "initialCameraFov": f"{camera[3]:.4f}"}, safe=",")

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
        self._closed.set()
        self._thread.join()
        with contextlib.redirect_stdout(io.StringIO()):
            self._viser.stop()

    def _furnish(self) -> None:
        gui, scene = self._viser.gui, self._viser.scene
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        scene.set_background_image(np.full((1, 1, 3), 26, np.uint8))
        # Viser's own light washes the colours out, and colours are roles here.
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map(None)
        scene.add_light_ambient("/light/ambient", intensity=1.7)
        scene.add_light_directional("/light/sun", intensity=2.0, position=(-1.0, -2.0, 2.0))

    def _aim_camera(self) -> None:
        view = self._viser.initial_camera
        view.position, view.look_at, view.up, view.fov = _cameras(self._actuator.length)["top"]

    def _run(self) -> None:
        shown = -1
        while not self._closed.wait(1 / RATE):
            try:
                shown = self._refresh(shown)
            except Exception:  # the view must come back after any surprise in one row
                log.exception("the 3D view could not be updated")

    def _refresh(self, shown: int) -> int:
        """Show the newest row unless it is on view already (tick `shown`); returns the tick on view."""
        newest = self._newest()
        if newest is None or not self._viser.get_clients():
            return shown
        if self._wanted() != self._actuator:
            self._rebuild()
        tick, moved = int(newest[0]["tick"]), self._dirty.is_set()
        if tick != shown or moved:
            self._dirty.clear()
            with self._viser.atomic():
                self._body.update(newest[0])
                if not self._dragged.is_set():
                    self._body.place_gizmo(gizmo_point(newest[0]), again=moved)
        return tick

    def _rebuild(self) -> None:
        """The rig that answers now has another actuator."""
        self._body.remove()
        self._actuator = self._wanted()
        self._body = Body(self._viser, self._actuator, self._light)
        self._aim_camera()


def _cameras(length: float) -> dict[str, tuple[Any, Any, Any, float]]:
    """Position, point looked at, up direction and vertical field of view of the views: actuator and reach fill them."""
    middle = (0.4 * length, 0.0, 0.0)
    top = ((middle[0], 0.0, 4.4 * length), middle, (0.0, 1.0, 0.0), 0.42)
    oblique = ((middle[0] - 1.2 * length, -2.9 * length, 2.7 * length), middle, (0.0, 0.0, 1.0), 0.42)
    return {"top": top, "oblique": oblique}
