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
from controller.schema.modes import Request
from server.audit import tell
from server.auth import Identity
from server.events import EventLog
from server.lease import OperatorLease
from server.operator import Operator
from server.permit import Permit, Permits
from server.scene import Scene
from server.scene.gizmo import GIZMO, Point

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
        lease: OperatorLease,
        operator: Operator,
        permits: Permits,
        scene: Scene,
        events: EventLog,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._who, self._lease, self._operator, self._scene = who, lease, operator, scene
        self._permits, self._events, self._now = permits, events, now
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
            permit = self._permits.operator(self._who)
        except NotAllowed as refusal:
            self._refuse(str(refusal))
            return None
        return _encode(message) if self._act(kind, message, permit) else None

    def end(self) -> None:
        """The drag is over: released, its page gone, or its lease lost."""
        if self._dragging:
            self._dragging = False
            self._scene.hold_gizmo(False)

    def leave(self) -> None:
        """Its page is gone; another tab of the session may still be present, but nobody there began this drag: hold."""
        if self._dragging and self._lease.holds(self._who):
            self._operator.request(Request.HOLD, self._permits.operator(self._who))
        self.end()

    def _refuse(self, reason: str) -> None:
        """Nothing moves, the gizmo goes back, and the log says once who tried."""
        self.end()
        self._scene.put_back()
        if self._now() - self._refused_at > PAUSE:
            self._events.refused(self._who.name, "drag in the 3D view", reason)
        self._refused_at = self._now()

    def _act(self, kind: str, message: dict[str, Any], permit: Permit) -> bool:
        self._lease.touch(self._who)
        self._operator.present(permit)
        if kind == START:
            self._start(permit)
        elif kind == END:
            self.end()
            if self._lease.clutch:
                self._operator.request(Request.HOLD, permit)
                tell("gizmo let go: hold")
        elif (at := _position(message)) is None:
            return False
        elif self._dragging:
            self._operator.move(at, permit)
        return True

    def _start(self, permit: Permit) -> None:
        """A fresh press: the only thing that may leave HOLD."""
        at = self._scene.gizmo()
        if at is not None:
            self._dragging = True
            self._scene.hold_gizmo(True)
            self._operator.request(Request.FOLLOW, permit, at)
            tell(f"follow by the gizmo, target at ({at[0]:.4f}, {at[1]:.4f}) m")


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
