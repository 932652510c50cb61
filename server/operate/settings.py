"""Live settings: law, sensors, gains, limits; and those of the last run, kept over a restart of this server."""

import asyncio
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter
from pydantic import ValidationError

from controller.errors import CommandRefused, ParameterError
from controller.schema.messages import RigInfo
from controller.schema.modes import Mode
from controller.schema.parameters import Settings
from controller.schema.slot import PREVIEW, PREVIEW_TUNING, TUNING
from controller.system.state_file import StateFile
from server.access.permit import Permit, Permitted
from server.http.given import given
from server.http.problems import malformed
from server.log.events import EventLog
from server.operate.messages import ControllerBody, SettingsBody
from server.operate.operator import GivenOperator, Operator
from server.rig.client import GivenRig

MOVING = (Mode.FOLLOW, Mode.TRACK)
FIRST = {"controller": PREVIEW, "tuning": (*PREVIEW_TUNING, *[0.0] * (TUNING - len(PREVIEW_TUNING)))}
"""In the slot as a server begins."""


class KeptSettings:
    """`changing`: changes are merged one after another."""

    def __init__(self, path: Path, events: EventLog, info: Callable[[], RigInfo | None] = lambda: None) -> None:
        """`info()` is who the rig is, None before the first contact."""
        self._file = StateFile(path, Settings.model_validate_json, "the rig begins with the default settings")
        self._events, self._info = events, info
        self.changing = asyncio.Lock()

    def read(self) -> Settings:
        """Those of the last run; the defaults when there are none, or none that this version understands.

        All but the controller: every server begins with `preview`, as another rig may have others in its slot.
        """
        return (self._file.read() or Settings()).model_copy(update=FIRST)

    async def keep(self, settings: Settings) -> None:
        """Remember what the rig has taken; it is in force even where that fails."""
        try:
            await asyncio.to_thread(self._file.write, settings.model_dump_json())
        except OSError as error:
            self._events.add(f"the settings will not outlive this server: {error}", "warning")

    async def change(self, body: SettingsBody, operator: Operator, permit: Permit) -> Settings:
        """Those that the rig then has; CommandRefused where it does not take them, ParameterError where it cannot."""
        async with self.changing:
            wanted, info = _merged(operator.settings, body), self._info()
            another = wanted.controller != operator.settings.controller and "tuning" not in body.changes
            if info and another and wanted.controller < len(info.controllers):
                wanted = wanted.model_copy(update={"tuning": tuple(tuning(info, wanted.controller))})
            strong = too_strong(wanted, info) if info else {}
            if why := [text for name, text in strong.items() if name in body.changes]:
                raise ParameterError("; ".join(why))
            await put_in_force(wanted, operator, permit)
            await self.keep(operator.settings)
        self._events.add(f"{permit.name}: {', '.join(f'{name} = {value}' for name, value in body.changes.items())}")
        return operator.settings


def chosen(body: ControllerBody, info: RigInfo) -> SettingsBody:
    """What it changes to put this controller into the slot. ParameterError with name, value and bound."""
    names = [one.name for one in info.controllers]
    if body.name not in names:
        raise ParameterError(f"controller = {body.name!r} is not one of {', '.join(names)}")
    number = names.index(body.name)
    if refused := info.controllers[number].refused:
        raise CommandRefused(f"refused: controller {body.name}: {refused}")
    about = info.controllers[number].tuning
    if unknown := sorted(set(given := body.tuning or {}) - {one.name for one in about}):
        known = ", ".join(one.name for one in about) or "none"
        raise ParameterError(f"tuning.{unknown[0]}: the numbers of controller {body.name} are {known}")
    for one in about:
        if not one.low <= (value := given.get(one.name, one.usual)) <= one.high:
            raise ParameterError(f"tuning.{one.name} = {value:g} is outside [{one.low:g}, {one.high:g}] {one.unit}")
    return SettingsBody(changes={"controller": number, "tuning": tuning(info, number, given)})


def tuning(info: RigInfo, number: int, given: Mapping[str, float] | None = None) -> list[float]:
    """The numbers (TUNING,) of the rig's controller of this number: as usual but for those `given` by name."""
    found = [(given or {}).get(one.name, one.usual) for one in info.controllers[number].tuning]
    return [*found, *[0.0] * (TUNING - len(found))]


async def put_in_force(wanted: Settings, operator: Operator, permit: Permit) -> None:
    """Let the rig have them, and keep them nowhere; CommandRefused where it does not take them."""
    reply = await asyncio.wrap_future(operator.change(wanted, permit))
    if not reply.accepted:
        raise CommandRefused(reply.detail)


def too_strong(settings: Settings, info: RigInfo) -> dict[str, str]:
    """Which of these gains the rig's observer would not be stable with, and how much it takes, in words."""
    controller, gains = info.parameters.controller, (("K_o", settings.K_o, "N/m"), ("B_o", settings.B_o, "N s/m"))
    return {
        name: f"{name} = {max(found):g} {unit} is above {most:.3g}, the most with which RK4 is stable with this "
        f"actuator and rods = {controller.rods} at dt = {controller.dt:g} s; integrator = implicit takes more"
        for (name, found, unit), most in zip(gains, info.observer_gains_max, strict=True)
        if max(found) > most
    }


GivenKeptSettings = Annotated[KeptSettings, given(KeptSettings)]

router = APIRouter(tags=["settings"])


@router.get("/api/settings")
async def read_settings(operator: GivenOperator) -> Settings:
    """The settings in force."""
    return operator.settings


@router.patch("/api/settings")
async def change_settings(
    body: SettingsBody, operator: GivenOperator, kept: GivenKeptSettings, permit: Permitted
) -> Settings:
    """Change some settings; in force (and returned) only when the rig has taken them."""
    return await kept.change(body, operator, permit)


@router.put("/api/controller")
async def choose_controller(
    body: ControllerBody, operator: GivenOperator, kept: GivenKeptSettings, rig: GivenRig, permit: Permitted
) -> Settings:
    """Put another controller into the slot, or tune the one that is there; in HOLD, or while the arm is not driven."""
    changes = chosen(body, rig.require_info())
    newest = rig.newest
    if (
        newest is not None
        and newest["mode"][0] in MOVING
        and changes.changes["controller"] != operator.settings.controller
    ):
        raise CommandRefused("refused: the controller changes in HOLD, not while the tip is on its way; hold first")
    return await kept.change(changes, operator, permit)


def _merged(before: Settings, body: SettingsBody) -> Settings:
    try:
        return Settings.model_validate({**before.model_dump(), **body.changes})
    except ValidationError as error:
        raise malformed(error, "body", "changes") from error
