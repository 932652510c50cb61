"""Gains with which the rig's observer would not be stable: refused with the bound, and told where a rig takes less."""

import asyncio
from concurrent.futures import Future
from pathlib import Path
from typing import cast

import pytest

from controller.assembly.rig import build_rig
from controller.errors import ParameterError
from controller.schema.actuator import PRESETS
from controller.schema.messages import CommandReply, RigInfo
from controller.schema.modes import Cause, Integrator, Mode
from controller.schema.parameters import ControllerParameters, RigParameters, Settings
from controller.system.event_bus import EventBus
from controller.system.scheduler import Scheduler
from recordings.write.run_file import simulated_rig
from server.access.lease import OperatorLease
from server.access.permit import Permit
from server.log.events import EventLog
from server.operate.detector import ChangeDetector
from server.operate.messages import SettingsBody
from server.operate.operator import Operator
from server.operate.people import PeopleHere
from server.operate.reactions import Reactions
from server.operate.settings import KeptSettings, too_strong
from server.rig.client import Rig
from tests.server.leave import ANYTHING

STRONG = Settings(K_o=(500.0, 500.0), B_o=(1.0, 5.0))


def info(integrator: Integrator) -> RigInfo:
    """Of P2 with 10 rods, as its rig says."""
    controller = ControllerParameters(integrator=integrator)
    parameters = RigParameters(actuator=PRESETS["P2"], controller=controller)
    K_o, B_o = build_rig(parameters, 1).observer.gain_max.tolist()
    return simulated_rig(parameters).model_copy(update={"observer_gains_max": (K_o, B_o)})


class Asked:
    """Rig and operator in one, with gains of another actuator."""

    trouble, paused, settings = "", False, STRONG

    def __init__(self) -> None:
        self.info = info(Integrator.RK4)

    def change(self, settings: Settings, permit: Permit) -> "Future[CommandReply]":
        self.settings, answer = settings, Future[CommandReply]()
        answer.set_result(CommandReply(n=1, accepted=True, mode=Mode.HOLD, cause=Cause.NONE, detail=""))
        return answer

    def boot(self) -> int:
        return 7


@pytest.mark.process
def test_only_rk4_takes_less_than_the_settings_allow() -> None:
    assert too_strong(STRONG, info(Integrator.IMPLICIT)) == {}
    (why,) = too_strong(STRONG, info(Integrator.RK4)).values()
    assert why.startswith("B_o = 5 N s/m is above 2.1, the most with which RK4 is stable") and "rods = 10" in why


def test_a_change_beyond_them_is_refused_before_the_rig_is_asked(tmp_path: Path) -> None:
    kept = KeptSettings(tmp_path / "settings.json", EventLog(), lambda: info(Integrator.RK4))
    body = SettingsBody(changes={"B_o": [5.0, 5.0]})
    with pytest.raises(ParameterError, match=r"^B_o = 5 N s/m is above 2\.1,"):
        asyncio.run(kept.change(body, cast(Operator, Asked()), ANYTHING))
    assert not (tmp_path / "settings.json").exists()


def test_what_another_actuator_left_too_strong_keeps_nobody_from_other_changes(tmp_path: Path) -> None:
    kept, asked = KeptSettings(tmp_path / "settings.json", EventLog(), lambda: info(Integrator.RK4)), Asked()
    found = asyncio.run(kept.change(SettingsBody(changes={"K_P": [0.1, 0.1]}), cast(Operator, asked), ANYTHING))
    assert found.K_P == (0.1, 0.1) and found.B_o == STRONG.B_o


def test_a_rig_that_takes_less_than_what_is_in_force_is_told_of_once() -> None:
    asked, events = Asked(), EventLog()
    bus, rig, operator = EventBus(Scheduler()), cast(Rig, asked), cast(Operator, asked)
    Reactions(rig, operator, cast(PeopleHere, None), events, bus)
    detector = ChangeDetector(rig, OperatorLease(), operator, bus)
    for _ in range(2):
        detector.look()
        bus.deliver()
    told = [event.text for event in events.recent if event.level == "warning"]
    assert len(told) == 1 and told[0].startswith("the rig takes less: B_o = 5 N s/m")
