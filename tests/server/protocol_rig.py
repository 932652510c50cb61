"""The rig of the protocol's model: the real link's end, command handler and tick, and what is on its way to them."""

import copy
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from controller.drivers.driver import Driver
from controller.errors import RigUnreachable
from controller.kernels.control.tick import tick
from controller.link import rig_end
from controller.link.keys import Keys
from controller.link.rig_end import RigEnd
from controller.link.seal import Seals
from controller.realtime import command_handler as handler_module
from controller.realtime.latch import Latch
from controller.realtime.mailbox import mailbox, receive, words
from controller.realtime.ring import create_ring, ring_push
from controller.schema.messages import CommandReply, RigInfo
from controller.schema.modes import Request
from controller.schema.parameters import RigParameters, SafetyLimits
from controller.system.keys import KEY_BYTES
from tests.controller.desk import MS
from tests.controller.desk import Desk as Ticked

if TYPE_CHECKING:
    from tests.server.protocol import Server, World

KEY, KEYS = b"k" * KEY_BYTES, Keys("test")
LIMITS = SafetyLimits(operator_timeout=10.0, server_hold=10.0, server_rest=600.0)
"""So long that no watchdog hides what the protocol lets through."""


@dataclass(eq=False)
class Asked:
    """One thing that someone asked for."""

    order: int
    request: Request
    """NONE: a target alone."""
    boot: int
    server: "Server"
    answer: "Future[CommandReply]"
    taken: int = 0
    """How often the loop accepted it."""
    carried: bool = False
    """An E-STOP that the boot of the rig that it was pressed for did not answer: it is meant for the next one, too."""

    @property
    def moves(self) -> bool:
        """Whether the rig may move by it."""
        return self.request in (Request.NONE, Request.FOLLOW, Request.TRACK)

    @property
    def said(self) -> bool | None:
        """Whether the asker was told that the rig took it; None: was told that no one knows, or nothing yet."""
        if not self.answer.done():
            return None
        error = self.answer.exception()
        if error is None:
            return self.answer.result().accepted
        return None if isinstance(error, RigUnreachable) else False


@dataclass(repr=False)
class Message:
    """A sealed message on its way."""

    boot: int
    key: str
    payload: bytes
    seal: bytes
    what: list[Asked]
    sent_ns: int


@cache
def _first_rig() -> Ticked:
    """A rig with a reference, as it starts: to build one takes longer than what is played with it."""
    found = Ticked(RigParameters(limits=LIMITS))
    found.plan(np.tile([0.25, 0.01], (60_000, 1)))
    return found


def _planned() -> dict[int, Any]:
    """What copies of the first rig share with it, because nothing here writes it."""
    control = _first_rig().rig.control
    return {id(one): one for one in (control.reference, control.guide, control.kinds, control.smap)}


DRIVER = SimpleNamespace(simulated=True, plant=None, unready=lambda: "")
LATCH = SimpleNamespace(kept=None, look=lambda row, by: None, clear=lambda row: None, on_disk=lambda timeout: "")
"""What it does is tests/controller/realtime/test_latch.py's matter, and the disk would take most of the time here."""


class Rig(Ticked):
    """One boot of a rig, and its end of the link."""

    def __init__(self, world: "World", boot: int) -> None:
        vars(self).update(copy.deepcopy(vars(_first_rig()), memo=_planned()))
        self.world, self.boot, self.seen, self.heard = world, boot, 0, world.now
        self.rig.control.state["boot"] = boot
        self.operator = False
        self.box = mailbox(self.command.dtype)
        self.scratch = np.zeros(len(words(self.command)), np.int64)
        self.ring = create_ring("test", boot, world.folder, capacity=256)
        info = RigInfo.model_construct(boot=boot, parameters=RigParameters(limits=LIMITS))
        outside = (cast(Any, None), cast(Driver, DRIVER), cast(Latch, LATCH))
        desk = handler_module.CommandHandler(info, self.ring, self.box, *outside)
        nothing = SimpleNamespace(undeclare=lambda: None)
        session: Any = SimpleNamespace(
            declare_publisher=lambda *given, **more: nothing,
            declare_queryable=lambda *given: nothing,
            liveliness=lambda: SimpleNamespace(declare_token=lambda key: nothing),
        )
        self.end = RigEnd(session, "test", Seals(KEY, boot, "key"), cast(rig_end.RigService, desk))
        self.end._holder._now = lambda: world.now * 1e-9

    def tick(self) -> None:
        """One tick, on whatever is in the mailbox."""
        self.now = self.world.now
        seen, self.seen = self.seen, receive(self.box, self.seen, self.scratch, words(self.command))
        self.heard = self.now if self.seen != seen else self.heard
        self.status["server_ns"], self.status["pump_ns"] = self.heard, self.now
        self.measurement["t_ns"] = self.now - MS
        hum = 1e-9 * (self.measurement["markers"][0, 0, 0] == self.markers[0, 0])
        self.measurement["markers"] = self.markers + hum
        before, row = self.telemetry[0].copy(), self.telemetry[0]
        tick(self.now, self.command[0], self.measurement[0], self.status[0], self.rig, row)
        differences = self.rig.observer.u_hat * self.rig.control.pascal_per_torque[::2]
        self.measurement["pressures"] = np.column_stack([differences, -differences]).clip(min=0.0).ravel()
        ring_push(self.ring.header, self.ring.rows, words(self.telemetry))
        self.world.judge(before, row)

    def hear(self, message: Message) -> bytes:
        """What the link's end makes of it."""
        answers: dict[str, Callable[[bytes, bytes], bytes]] = {
            KEYS.command: self.end._command,
            KEYS.stop: self.end._stop,
            KEYS.session: self.end._session,
        }
        self.world.delivered.append(message)
        return answers[message.key](message.payload, message.seal)
