"""What may pass up to viser, and what a drag does, judged by its sender."""

from typing import Any, cast

import msgpack
import pytest

from controller.schema.modes import Request
from server.access.lease import OperatorLease
from server.access.permit import Permit
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.operator import Operator
from server.operate.target_control import TargetContext
from server.rig.history import History
from server.scene.drag import CAMERA, END, START, UPDATE, Drag
from server.scene.scene import GIZMO, Scene
from tests.server.leave import permits_of

ANN, BOB = Identity("a", "ann"), Identity("b", "bob")


class Recorded:
    """Operator and scene in one: keeps what was called."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []

    def __getattr__(self, name: str) -> Any:
        return lambda *given: self.calls.append((name, *(one for one in given if not isinstance(one, Permit))))

    def gizmo(self) -> tuple[float, float]:
        return (0.2, 0.0)


@pytest.fixture
def lease() -> OperatorLease:
    found = OperatorLease()
    found.acquire(ANN)
    return found


def hands(seen: "Recorded", lease: OperatorLease, events: EventLog) -> TargetContext:
    return TargetContext(lease, permits_of(lease), cast(Operator, seen), History(), events)


def drag_of(who: Identity, lease: OperatorLease) -> tuple[Drag, Recorded]:
    seen = Recorded()
    return Drag(who, hands(seen, lease, EventLog()), cast(Scene, seen)), seen


def gizmo(kind: str, **more: Any) -> bytes:
    return bytes(msgpack.packb({"type": kind, "name": GIZMO, "owner": "", **more}))


def test_a_viewer_gets_only_the_camera_through(lease: OperatorLease) -> None:
    drag, seen = drag_of(BOB, lease)
    camera = {"type": CAMERA, "fov": 0.4}
    assert msgpack.unpackb(drag.judge(msgpack.packb(camera)) or b"") == camera
    for kind in (START, UPDATE, END):
        assert drag.judge(gizmo(kind, position=[0.1, 0.1, 0.0], wxyz=[1, 0, 0, 0])) is None
    assert {call[0] for call in seen.calls} == {"put_back"}


def test_the_log_names_a_viewer_who_drags_once_for_each_attempt(lease: OperatorLease) -> None:
    seen, events, now, told = Recorded(), EventLog(), [0.0], list[str]()
    drag = Drag(BOB, hands(seen, lease, events), cast(Scene, seen), told.append, lambda: now[0])
    for now[0] in (0.0, 2.0, 6.0, 10.5, 30.0):
        drag.judge(gizmo(START))
        drag.judge(gizmo(UPDATE, position=[0.1, 0.1, 0.0]))
    line = "bob: drag in the 3D view refused: only the operator may do this; ann operates now"
    assert [(event.level, event.text) for event in events.recent] == [("warning", line)] * 2
    assert told == ["only the operator may do this; ann operates now"] * 5  # each press; not each move that follows


@pytest.mark.parametrize(
    "raw",
    [
        b"",
        b"\xc1",
        b"\xff" * 40,
        "text",
        None,
        msgpack.packb([1, 2]),
        msgpack.packb({"type": 3}),
        msgpack.packb({"type": CAMERA}) + b"\x00",
        msgpack.packb({"type": "ShareUrlRequest"}),
        msgpack.packb({"type": "GuiUpdateMessage", "uuid": "x", "updates": {}}),
        msgpack.packb({"type": UPDATE, "name": "/other", "owner": "", "position": [0, 0, 0]}),
        msgpack.packb({"type": UPDATE, "name": GIZMO, "owner": "other", "position": [0, 0, 0]}),
        b"\x91" * 5000,
    ],
)
def test_nobody_gets_anything_else_through(raw: bytes | str | None, lease: OperatorLease) -> None:
    drag, seen = drag_of(ANN, lease)
    assert drag.judge(raw) is None
    assert seen.calls == []


def test_a_key_given_twice_is_passed_on_only_as_it_was_judged(lease: OperatorLease) -> None:
    twice = b"\x82" + msgpack.packb("type") + msgpack.packb(UPDATE) + msgpack.packb("type") + msgpack.packb(CAMERA)
    drag, _ = drag_of(BOB, lease)
    assert drag.judge(twice) == msgpack.packb({"type": CAMERA})


def test_the_operators_drag_is_a_fresh_follow_then_moves(lease: OperatorLease) -> None:
    drag, seen = drag_of(ANN, lease)
    assert drag.judge(gizmo(START))
    assert drag.judge(gizmo(UPDATE, position=[0.1, 9.0, 0.5], wxyz=[1, 0, 0, 0]))
    assert drag.judge(gizmo(END))
    assert [call for call in seen.calls if call[0] != "present"] == [
        ("hold_gizmo", True),
        ("request", Request.FOLLOW, (0.2, 0.0)),
        ("request", Request.NONE, (0.1, 2.0)),
        ("hold_gizmo", False),
    ]


def test_a_move_without_a_press_moves_nothing(lease: OperatorLease) -> None:
    drag, seen = drag_of(ANN, lease)
    drag.judge(gizmo(UPDATE, position=[0.1, 0.1, 0.0], wxyz=[1, 0, 0, 0]))
    assert {call[0] for call in seen.calls} == {"present"}


@pytest.mark.parametrize("position", [None, [0.1, 0.1], [0.1, float("nan"), 0.0], ["a", 0, 0], [float("inf"), 0, 0]])
def test_a_position_that_is_no_point_is_dropped(position: Any, lease: OperatorLease) -> None:
    drag, seen = drag_of(ANN, lease)
    drag.judge(gizmo(START))
    assert drag.judge(gizmo(UPDATE, position=position, wxyz=[1, 0, 0, 0])) is None
    assert "move" not in {call[0] for call in seen.calls}


def test_losing_the_lease_ends_the_drag(lease: OperatorLease) -> None:
    drag, seen = drag_of(ANN, lease)
    drag.judge(gizmo(START))
    lease.release(ANN)
    assert drag.judge(gizmo(UPDATE, position=[0.1, 0.1, 0.0], wxyz=[1, 0, 0, 0])) is None
    assert seen.calls[-2:] == [("hold_gizmo", False), ("put_back",)]
    assert "move" not in {call[0] for call in seen.calls}


def test_with_the_clutch_on_letting_go_of_the_gizmo_holds(lease: OperatorLease) -> None:
    drag, seen = drag_of(ANN, lease)
    lease.clutch = True
    for kind in (START, END):
        drag.judge(gizmo(kind))
    assert [call[1] for call in seen.calls if call[0] == "request"] == [Request.FOLLOW, Request.HOLD]
