"""What the server does by itself when the rig or the lease changes."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from controller.arrays import Rows
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import Settings
from controller.system.event_bus import EventBus
from controller.system.scheduler import Scheduler
from server.access import lease as leases
from server.access.lease import OperatorLease
from server.access.permit import Permits
from server.access.sessions import Sessions
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.detector import ChangeDetector
from server.operate.events import (
    BootChanged,
    LeaseChanged,
    ModeChanged,
    ObserverReseated,
    SettingsChanged,
    TroubleChanged,
)
from server.operate.operator import Operator
from server.operate.people import PeopleHere
from server.operate.reactions import Reactions
from server.rig.client import Rig
from server.rig.history import History

ANN, BOB = Identity("a", "ann"), Identity("b", "bob")
KINDS = (BootChanged, TroubleChanged, ModeChanged, ObserverReseated, LeaseChanged, SettingsChanged)


class Asked:
    """Rig and operator in one: connected, and keeps what was asked for."""

    trouble, paused, info, settings = "", False, None, Settings()

    def __init__(self) -> None:
        self.requests: list[Request] = []
        self.met: int | None = 7
        self.heard, self.overs, self.by = True, 0, ""
        self.history, self.stopper = History(), self

    @property
    def newest(self) -> Rows | None:
        return self.history.newest

    def boot(self) -> int | None:
        return self.met if self.heard else None

    def hold_left(self) -> None:
        self.requests.append(Request.HOLD)

    def over(self) -> None:
        self.overs += 1


class Scene:
    """A detector, what it publishes, and what follows."""

    def __init__(self, lease: OperatorLease | None = None) -> None:
        self.asked, self.lease, self.events = Asked(), lease or OperatorLease(), EventLog()
        self.bus, self.told = EventBus(Scheduler()), list[Any]()
        self.away: Identity | None = None
        rig, operator = cast(Rig, self.asked), cast(Operator, self.asked)
        for kind in KINDS:
            self.bus.subscribe(kind, "the test", self.told.append)
        Reactions(rig, operator, cast(PeopleHere, self), self.events, self.bus)
        self.detector = ChangeDetector(rig, self.lease, operator, self.bus)
        self.asked.history.listen(self.detector.rows)

    def is_here(self, who: Identity) -> bool:
        return who != self.away

    def note_missed(self) -> str:
        return "the page of ann is closed"

    def look(self) -> None:
        self.detector.look()
        self.bus.deliver()

    def rows(self, *modes: Mode, first: int = 0, reseats: list[int] | int = 0) -> None:
        rows = np.zeros(len(modes), record_dtype(Telemetry))
        rows["tick"], rows["mode"], rows["reseats"] = first + np.arange(len(modes)), modes, reseats
        self.asked.history.add(rows)
        self.bus.deliver()

    def of(self, kind: type) -> list[Any]:
        return [event for event in self.told if type(event) is kind]


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("handed_on", [False, True])
def test_a_new_operator_inherits_no_motion(mode: Mode, handed_on: bool) -> None:
    """In HOLD too: a FOLLOW of the old operator may be on its way. A rig that rests or is stopped is left alone."""
    scene = Scene()
    scene.rows(mode)
    assert scene.lease.acquire(ANN)
    scene.look()
    assert scene.asked.requests == []
    scene.lease.release(ANN)
    if handed_on:
        assert scene.lease.acquire(BOB)
    scene.look()
    scene.look()
    assert scene.asked.requests == [Request.HOLD] * (mode in (Mode.HOLD, Mode.FOLLOW, Mode.TRACK))


def test_a_rig_that_takes_no_command_is_told_once_and_when_it_takes_them_again() -> None:
    scene = Scene()
    scene.look()
    for scene.asked.trouble in ("another server", "another server", "", ""):
        scene.look()
    told = [(event.level, event.text) for event in scene.events.recent if "from this server" in event.text]
    assert told[0] == ("error", "the rig takes no command from this server: another server")
    assert [level for level, _ in told] == ["error", "info"]


def test_each_reseat_of_the_observer_is_told_once_and_none_that_was_there_before() -> None:
    scene = Scene()
    for first, reseats in ((1, [1, 1]), (3, [2, 2]), (5, [3, 3])):
        scene.rows(Mode.HOLD, Mode.HOLD, first=first, reseats=reseats)
    told = [event for event in scene.events.recent if "observer" in event.text]
    assert [event.level for event in told] == ["warning"] * 2 and "wound" in told[0].text
    assert [event.tick for event in scene.of(ObserverReseated)] == [3, 5]


def test_a_mode_that_lasts_one_tick_is_told_in_its_place() -> None:
    scene = Scene()
    scene.rows(Mode.HOLD, Mode.FOLLOW, Mode.FAULT, Mode.HOLD, Mode.HOLD)
    scene.rows(Mode.HOLD, Mode.TRACK, first=5)
    found = [(event.tick, event.before, event.mode) for event in scene.of(ModeChanged)]
    assert found == [
        (0, None, Mode.HOLD),
        (1, Mode.HOLD, Mode.FOLLOW),
        (2, Mode.FOLLOW, Mode.FAULT),
        (3, Mode.FAULT, Mode.HOLD),
        (6, Mode.HOLD, Mode.TRACK),
    ]
    assert [event.text.split(" (")[0] for event in scene.events.recent if event.text.startswith("rig:")] == [
        "rig: FOLLOW",
        "rig: FAULT",
        "rig: HOLD",
        "rig: TRACK",
    ]


def test_another_cause_of_the_same_mode_is_told() -> None:
    scene = Scene()
    rows = np.zeros(2, record_dtype(Telemetry))
    rows["mode"], rows["cause"] = Mode.HOLD, [Cause.OPERATOR, Cause.SERVER_LOST]
    scene.asked.history.add(rows)
    scene.bus.deliver()
    assert [(event.before, event.cause) for event in scene.of(ModeChanged)][1:] == [(Mode.HOLD, Cause.SERVER_LOST)]


def test_another_boot_between_two_looks_is_told_before_its_rows_and_its_first_mode_is_no_change() -> None:
    scene = Scene()
    scene.rows(Mode.E_STOP)
    scene.look()
    scene.asked.history.forget()
    scene.asked.met = 8
    scene.rows(Mode.VENTED, Mode.HOLD)
    scene.look()
    assert scene.told == [
        BootChanged(7, None),
        ModeChanged(0, Mode.E_STOP, Cause.NONE, None),
        BootChanged(8, 7),
        ModeChanged(0, Mode.VENTED, Cause.NONE, None),
        ModeChanged(1, Mode.HOLD, Cause.NONE, Mode.VENTED),
    ]
    assert [event.text for event in scene.events.recent] == [
        "the rig is connected",
        "the rig restarted: arm it again",
        "rig: HOLD (none)",
    ]
    assert scene.asked.overs == 1, "who pressed E-STOP did so in the boot before"


def test_a_rig_that_falls_silent_and_comes_back_is_told_as_gone_and_connected() -> None:
    scene = Scene()
    scene.look()
    for scene.asked.heard in (False, False, True):
        scene.look()
    assert scene.of(BootChanged) == [BootChanged(7, None), BootChanged(None, 7), BootChanged(7, 7)]
    assert [event.text for event in scene.events.recent] == [
        "the rig is connected",
        "the rig is gone",
        "the rig is connected",
    ]


def test_an_e_stop_that_is_left_is_over_for_who_pressed_it() -> None:
    scene = Scene()
    scene.asked.by = "ann"
    scene.rows(Mode.HOLD, Mode.E_STOP)
    assert scene.asked.overs == 0
    scene.rows(Mode.VENTED, first=2)
    assert scene.asked.overs == 1


def test_every_change_of_the_lease_is_told_in_order_and_its_lapse_too() -> None:
    now = [0.0]
    scene = Scene(OperatorLease(lambda: now[0]))
    scene.lease.acquire(ANN)
    scene.lease.give(BOB, "bob took control over")
    scene.lease.give(BOB, "bob took control over")
    scene.lease.release(BOB)
    scene.lease.acquire(ANN)
    scene.look()
    now[0], scene.away = leases.LAPSE_S + 0.1, ANN
    scene.look()
    scene.look()
    changes = [(event.before, event.holder) for event in scene.of(LeaseChanged)]
    assert changes == [(None, ANN), (ANN, BOB), (BOB, None), (None, ANN), (ANN, None)]
    assert [event.text for event in scene.events.recent if "operates" in event.text] == [
        "ann operates",
        "ann no longer operates: bob took control over",
        "bob operates",
        "bob no longer operates: control was released",
        "ann operates",
        f"ann no longer operates: nothing was heard of the page for {leases.LAPSE_S:g} s; its page is closed",
    ]
    assert [scene.lease.view(who).lost for who in (ANN, BOB)] == [
        f"nothing was heard of the page for {leases.LAPSE_S:g} s",
        "control was released",
    ]
    assert scene.lease.acquire(BOB) and scene.lease.view(BOB).lost == ""


def test_a_hold_for_lack_of_a_sign_says_whose() -> None:
    scene = Scene()
    rows = np.zeros(2, record_dtype(Telemetry))
    rows["tick"], rows["mode"] = [0, 1], [Mode.FOLLOW, Mode.HOLD]
    rows["cause"] = [Cause.OPERATOR, Cause.OPERATOR_LOST]
    scene.asked.history.add(rows)
    scene.bus.deliver()
    assert scene.events.recent[-1].text == "rig: HOLD (the page of ann is closed)"


def test_it_is_said_which_sign_was_missed_the_nearest_to_its_person_first() -> None:
    now, here = [0.0], [ANN]
    lease, sessions = OperatorLease(lambda: now[0]), cast(Sessions, SimpleNamespace(stands=lambda who: True))
    permits = Permits(lease, sessions, lambda: 0.5, lambda: now[0])
    people = PeopleHere(lambda: here, lease, cast(Operator, None), permits, EventLog())
    lease.acquire(ANN)
    permits.signed(ANN)
    now[0] = 0.2
    assert people.note_missed() == "signs of ann came, none reached the rig for 0.5 s: server or link too slow"
    now[0] = 0.6
    assert people.note_missed() == "no sign of ann's open page for 0.5 s: browser or network too slow"
    here.clear()
    assert people.note_missed() == people.missed == "the page of ann is closed"


def test_what_is_remembered_of_lost_control_has_a_bound() -> None:
    lease = OperatorLease(lambda: 0.0)
    passers = [Identity(str(n), str(n)) for n in range(leases.REMEMBERED_MAX + 2)]
    for who in passers:
        lease.give(who, "taken over")
    assert [lease.lost(who) for who in passers[:2]] == ["", "taken over"]


def test_settings_that_the_rig_has_taken_are_told_once() -> None:
    scene = Scene()
    scene.look()
    scene.asked.settings = Settings(K_P=(0.1, 0.1))
    for _ in range(2):
        scene.look()
    assert scene.of(SettingsChanged) == [SettingsChanged(Settings(K_P=(0.1, 0.1)))]
