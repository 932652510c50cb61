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

from controller.modes import Mode
from controller.parameters import SENSORS, Actuator
from server.channels import Rows
from server.colours import BASE, DANGER, MEASURED, OBSERVER, REFERENCE, TARGET

RATE = 30.0
GIZMO = "/target"
"""Scene name of the gizmo: the only thing in viser that a session may drag."""

Point = tuple[float, float]


class Scene:
    """Viser on a free port of 127.0.0.1, updated at 30 Hz while anyone looks."""

    def __init__(self, newest: Callable[[], Rows | None], actuator: Actuator, light: bool = False) -> None:
        self._newest = newest
        with contextlib.redirect_stdout(io.StringIO()):  # its banner names an address that nobody should open
            self._viser = viser.ViserServer(host="127.0.0.1", port=0, label="Tendril", verbose=False)
        # Any client may ask for a public tunnel; there is none to be had.
        setattr(self._viser, "request_share_url", lambda *_, **__: None)  # noqa: B010
        logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
        self._body: Body | None = None
        self._light = light
        self._dragged = threading.Event()
        self._dirty = threading.Event()
        self._closed = threading.Event()
        self._furnish()
        self.show(actuator)
        self._thread = threading.Thread(target=self._run, name="scene", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Port that viser listens on."""
        return int(self._viser.get_port())

    def show(self, actuator: Actuator) -> None:
        """Draw the bodies of this actuator, instead of the ones before."""
        if self._body is not None:
            self._body.remove()
        self._actuator = actuator
        self._body = Body(self._viser, actuator, self._light)
        camera = _cameras(actuator.length)["top"]
        view = self._viser.initial_camera
        view.position, view.look_at, view.up, view.fov = camera
        self._dirty.set()

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

    def _run(self) -> None:
        shown = -1
        while not self._closed.wait(1 / RATE):
            newest = self._newest()
            if newest is None or self._body is None or not self._viser.get_clients():
                continue
            tick = int(newest[0]["tick"])
            moved = self._dirty.is_set()
            if tick == shown and not moved:
                continue
            shown = tick
            self._dirty.clear()
            with self._viser.atomic():
                self._body.update(newest[0])
                if not self._dragged.is_set():
                    self._body.place_gizmo(gizmo_point(newest[0]), again=moved)


class Body:
    """Everything in the scene that belongs to one actuator."""

    def __init__(self, server: viser.ViserServer, actuator: Actuator, light: bool) -> None:
        scene, h = server.scene, actuator.height
        rod = (actuator.length / SENSORS, actuator.width, h)
        self._rods = [scene.add_box(f"/arm/rod{i + 1}", dimensions=rod, color=OBSERVER) for i in range(SENSORS)]
        block = (0.4 * actuator.width, 1.6 * actuator.width, 1.2 * h)
        self._base = scene.add_box("/base", dimensions=block, color=BASE, position=(-block[0] / 2, 0.0, 0.0))
        self._above = h / 2
        self._markers = [scene.add_icosphere(f"/marker/{i + 1}", 0.004, color=MEASURED) for i in range(SENSORS)]
        self._reference = scene.add_icosphere("/reference", 0.005, color=REFERENCE)
        self._target = scene.add_icosphere("/wish", 0.0035, color=TARGET)
        self._gizmo = scene.add_transform_controls(
            GIZMO,
            scale=0.06,
            active_axes=(True, True, False),
            disable_axes=True,
            disable_rotations=True,
            depth_test=False,
            position=(actuator.length, 0.0, 0.0),
        )
        self._others = [] if light else [_grid(server, actuator)]

    def remove(self) -> None:
        """Take everything out of the scene."""
        balls = (*self._markers, self._reference, self._target)
        for item in (*self._rods, self._base, *balls, self._gizmo, *self._others):
            item.remove()

    def update(self, row: Any) -> None:
        """Show one telemetry row."""
        backbone = np.asarray(row["backbone"], np.float64)
        if np.isfinite(backbone).all():
            self._place_rods(backbone)
        stopped = int(row["mode"]) in (Mode.FAULT, Mode.E_STOP)
        self._base.color = DANGER if stopped else BASE
        sensed = int(row["sensed"])
        for i, (ball, at) in enumerate(zip(self._markers, row["markers"], strict=True)):
            self._place(ball, at, shown=bool(sensed >> i & 1) or i == SENSORS - 1)
        moving = int(row["mode"]) in (Mode.HOLD, Mode.FOLLOW, Mode.TRACK)
        self._place(self._reference, row["p_ref"], moving)
        self._place(self._target, row["target"], int(row["mode"]) == Mode.FOLLOW)

    def place_gizmo(self, at: Point, again: bool) -> None:
        """Move the gizmo; `again` sends the pose even where the server believes it is there already."""
        if again:
            self._gizmo.position = (at[0], at[1], 1e-6)
        self._gizmo.position = (at[0], at[1], 0.0)

    def _place_rods(self, backbone: Rows) -> None:
        """Rod i lies between backbone samples 2i and 2i + 2, its middle at 2i + 1."""
        along = np.diff(backbone[::2], axis=0)
        half = np.arctan2(along[:, 1], along[:, 0]) / 2
        for box, (x, y), c, s in zip(self._rods, backbone[1::2], np.cos(half), np.sin(half), strict=True):
            box.position = (x, y, 0.0)
            box.wxyz = (c, 0.0, 0.0, s)

    def _place(self, ball: Any, at: Rows, shown: bool) -> None:
        ball.visible = shown = shown and bool(np.isfinite(at).all())
        if shown:
            ball.position = (at[0], at[1], self._above)


def gizmo_point(row: Any) -> Point:
    """Where the gizmo belongs: on the target while following, else where a drag would start, on the tip."""
    mode = int(row["mode"])
    field = "target" if mode in (Mode.FOLLOW, Mode.TRACK) else "p_ref" if mode == Mode.HOLD else "p_hat"
    x, y = float(row[field][0]), float(row[field][1])
    return (x, y) if np.isfinite(x + y) else (0.0, 0.0)


def _cameras(length: float) -> dict[str, tuple[Any, Any, Any, float]]:
    """Position, point looked at, up direction and vertical field of view of the views: actuator and reach fill them."""
    middle = (0.35 * length, 0.0, 0.0)
    top = ((middle[0], 0.0, 5.2 * length), middle, (0.0, 1.0, 0.0), 0.42)
    oblique = ((middle[0] - 1.6 * length, -3.4 * length, 3.2 * length), middle, (0.0, 0.0, 1.0), 0.42)
    return {"top": top, "oblique": oblique}


def _grid(server: viser.ViserServer, actuator: Actuator) -> Any:
    return server.scene.add_grid(
        "/ground",
        width=8 * actuator.length,
        height=8 * actuator.length,
        cell_size=0.05,
        section_size=0.25,
        cell_color=(60, 60, 60),
        section_color=(90, 90, 90),
        position=(0.0, 0.0, -actuator.height / 2 - 1e-3),
    )
