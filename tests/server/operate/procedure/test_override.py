"""Settings that are put back, wherever a procedure has ended."""

import asyncio
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any, cast

from controller.schema.modes import Law
from controller.schema.parameters import Settings
from server.access.permit import own
from server.operate.procedure.override import BLIND, SettingsOverride


class SlowOperator:
    """Stands for the rig's client: `answers` says whether the rig has taken a change and answered."""

    def __init__(self) -> None:
        self.settings, self.answers = Settings(), True

    def change(self, wanted: Settings, permit: Any) -> Future[Any]:
        answer: Future[Any] = Future()
        if self.answers:
            self.settings = wanted
            answer.set_result(SimpleNamespace(accepted=True, detail=""))
        return answer


class Kept:
    """Settings that are kept nowhere."""

    def __init__(self) -> None:
        self.changing = asyncio.Lock()

    async def keep(self, settings: Settings) -> None:
        pass


async def test_a_procedure_that_ends_while_the_rig_is_asked_leaves_no_torque_behind() -> None:
    operator, before = SlowOperator(), Settings()
    override = SettingsOverride(cast(Any, operator), cast(Any, Kept()), own())
    await override.put(**BLIND)
    await override.put(u_open=(0.001, 0.0))
    operator.answers = False
    asked = asyncio.create_task(override.put(u_open=(0.002, 0.0)))
    await asyncio.sleep(0)
    asked.cancel()
    await asyncio.wait([asked])
    assert operator.settings.u_open == (0.001, 0.0) and operator.settings.law == Law.OPEN_LOOP
    operator.answers = True
    await override.restore()
    assert operator.settings == before


async def test_what_others_changed_meanwhile_stays() -> None:
    operator = SlowOperator()
    override = SettingsOverride(cast(Any, operator), cast(Any, Kept()), own())
    await override.put(**BLIND)
    operator.settings = operator.settings.model_copy(update={"K_P": (0.1, 0.1)})
    await override.restore()
    assert operator.settings == Settings(K_P=(0.1, 0.1))
