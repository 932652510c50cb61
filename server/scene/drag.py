"""Which messages of a browser may reach viser, and what dragging the gizmo asks of the rig.

Every message is judged for the session that sent it, at the moment it arrives, and passed on as it was understood here:
viser never sees bytes that were not judged.
"""

import math
import time
from collections.abc import Callable
from typing import Any

import msgpack  # type: ignore[import-untyped]

from controller.errors import NotAllowed
from server.http.who import Identity
from server.operate.target_control import TargetContext, TargetControl
from server.scene.scene import GIZMO, Point, Scene

CAMERA = "ViewerCameraMessage"
START, UPDATE, END = (f"TransformControls{phase}Message" for phase in ("DragStart", "Update", "DragEnd"))
PAUSE = 5.0
"""Refused messages closer together than this are one attempt: one line in the log [s]."""
REACH = 2.0
"""Bound of a coordinate that is passed on [m]; the rig itself projects targets into its reach."""


class Drag:
    """The upward half of one viser connection."""

    def __init__(
        self,
        who: Identity,
        context: TargetContext,
        scene: Scene,
        refused: Callable[[str], object] = lambda reason: None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """`refused` tells the page why a press of the gizmo moves nothing."""
        self._who, self._scene, self._events, self._now = who, scene, context.events, now
        self._refused = refused
        self._target = TargetControl(who, context, "gizmo")
        self._dragging = False
        self._refused_at = -math.inf

    def judge(self, raw: bytes | str | None) -> bytes | None:
        """The message to pass on to viser, None to drop it; a drag of the lease's holder also moves the target."""
        message = _decode(raw)
        if message is None:
            return None
        kind = message["type"]
        if kind == CAMERA:
            return _encode(message)
        if kind not in (START, UPDATE, END) or message.get("name") != GIZMO or message.get("owner", "") != "":
            return None
        try:
            return _encode(message) if self._act(kind, message) else None
        except NotAllowed as refusal:
            self._refuse(str(refusal), pressed=kind == START)
            return None

    def end(self) -> None:
        """The drag is over: released, its page gone, or its lease lost."""
        if self._dragging:
            self._dragging = False
            self._scene.hold_gizmo(False)

    def leave(self) -> None:
        """Its page is gone, or this view of it alone."""
        if self._dragging:
            self._target.leave(followed=True)
        self.end()

    def _refuse(self, reason: str, pressed: bool) -> None:
        """Nothing moves, the gizmo goes back, its page is told why, and the log says once who tried."""
        if pressed or self._dragging:
            self._refused(reason)
        self.end()
        self._scene.put_back()
        if self._now() - self._refused_at > PAUSE:
            self._events.refused(self._who.name, "drag in the 3D view", reason)
        self._refused_at = self._now()

    def _act(self, kind: str, message: dict[str, Any]) -> bool:
        """Whether the message is passed on; NotAllowed unless `who` operates."""
        at = _position(message) if kind == UPDATE else None
        if at is not None and self._dragging:
            self._target.move(at)
            return True
        self._target.sign()
        if kind == START:
            self._start()
        elif kind == END:
            self.end()
            self._target.release()
        return kind != UPDATE or at is not None

    def _start(self) -> None:
        if (at := self._scene.gizmo()) is not None:
            self._dragging = True
            self._scene.hold_gizmo(True)
            self._target.press(at)


def _decode(raw: bytes | str | None) -> dict[str, Any] | None:
    if not isinstance(raw, bytes):
        return None
    try:
        message = msgpack.unpackb(raw)
    except (ValueError, msgpack.UnpackException):
        return None
    return message if isinstance(message, dict) and isinstance(message.get("type"), str) else None


def _encode(message: dict[str, Any]) -> bytes:
    return bytes(msgpack.packb(message))


def _position(message: dict[str, Any]) -> Point | None:
    """The gizmo's place in the plane, None unless it is three finite numbers."""
    at = message.get("position")
    if not isinstance(at, list) or len(at) != 3 or not all(isinstance(x, int | float) for x in at):
        return None
    if not all(math.isfinite(x) for x in at):
        return None
    x, y = (min(REACH, max(-REACH, float(c))) for c in at[:2])
    return x, y
