"""The measurement of the first mode: small steps to either side of the rest, in open loop, as a procedure.

No file ever has its law and torques.
"""

import asyncio
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated

import numpy as np

from controller.errors import CommandRefused
from controller.schema.modes import Law, Mode, Request
from server.access.permit import Permit
from server.hardware.first_mode import planning
from server.hardware.first_mode.messages import FirstModeBody, FirstModeState, KeptMode, MeasuredMode
from server.hardware.first_mode.store import FirstModes, plant_of
from server.http.given import given
from server.log.events import words
from server.operate.procedure.motion import require_mode
from server.operate.procedure.procedure import Procedure, Procedures
from server.rig.history import Gathered
from server.rig.planner import Planner

SWING_MAX = 1e-3
"""The arm rests where its tip swings by less (rms) [m]."""
STEP_MIN_S, STEP_MAX_S = 1.5, 4.0
"""A step is given so long at least, and at most."""
JUDGED = ("slot", "pressure_meas", "u_hat", "p_meas")
"""What is looked at of telemetry."""


@dataclass(frozen=True)
class Parts:
    """What it works through."""

    procedures: Procedures
    planner: Planner
    modes: FirstModes


class Measuring(Procedure):
    """One measurement as it goes."""

    def __init__(self, parts: Parts, body: FirstModeBody, torque: float, permit: Permit) -> None:
        super().__init__(parts.procedures.context, "measurement of the first mode", permit)
        self._parts, self._body, self._torque = parts, body, torque
        self._doing, self._step, self._count = "goes to its rest", 0, 2 * body.repeats
        self.slots: list[int] = []
        """At which each step began, and the last one ended."""
        self.seen: Gathered | None = None
        """Telemetry from the first step on."""

    def view(self) -> FirstModeState:
        """As pages see it."""
        by, doing = self.starter.name, self._doing
        return FirstModeState(
            by=by, state=self.state, doing=doing, step=self._step, steps=self._count, reason=self.reason
        )

    def where(self) -> str:
        """What it does."""
        return f", {self._doing}"

    async def steps(self) -> None:
        """Swing, give the rig back, then find the mode and keep it."""
        await self._swing()
        self.has_rig = False
        await self.give_back()
        self._doing = "finds the mode that fits"
        assert self.seen is not None
        rows, parameters = self.seen.rows(), self.info.parameters
        slots = tuple(self.slots)
        await self._keep(await self._parts.planner.do(planning.measured, rows, slots, self._body, parameters))
        self._doing = "done"

    def begin_step(self) -> None:
        """Note when, and take what the one before has shown: a minute of rows is kept, and less of a fast loop."""
        row = self.row()
        now = float(row["t_ns"]) * 1e-9
        self.slots.append(int(row["slot"]))
        if self.seen is None:
            self.seen = Gathered(self.context.history, now, JUDGED)
        self.seen.take(now)

    async def _swing(self) -> None:
        """The steps, from the pose in which the rig holds and back to it."""
        held = await self.ask(Request.HOLD)
        here = (float(held["u"][0]), float(held["u"][1]))
        there, back = (self._torque, self._torque), (-self._torque, -self._torque)
        await self.override.put(law=Law.OPEN_LOOP, u_open=here)
        await self.follow(held)
        await self.lead(here, back)
        await self._settle()
        for step in range(1, self._count + 1):
            self._step, self._doing = step, f"step {step} of {self._count}"
            self.begin_step()
            await self.torque(there if step % 2 else back)
            await self._settle()
        self.begin_step()
        self._doing = "goes back to where it held"
        await self.lead(back, here)
        self.follows = False
        await self.ask(Request.HOLD)

    async def _settle(self) -> None:
        """Wait until the arm rests, or for as long as a step is given."""
        await self.still(STEP_MIN_S, STEP_MAX_S, SWING_MAX)

    async def _keep(self, mode: MeasuredMode) -> None:
        actuator, zeta, kappa = self.info.parameters.actuator, mode.zeta, mode.kappa
        kept = KeptMode(actuator=actuator, plant=plant_of(self.info), measured=datetime.now(UTC), mode=mode)
        try:
            await asyncio.to_thread(self._parts.modes.keep, kept)
        except OSError as error:
            raise CommandRefused(f"it cannot be kept: {error.strerror}") from error
        self.outcome = (
            f"first mode of {actuator.name} measured: {mode.frequency.value:.2f} Hz, damping ratio "
            f"{zeta.value:.3f} ({zeta.low:.3f} to {zeta.high:.3f}), kappa {kappa.value:.1f} "
            f"({kappa.low:.1f} to {kappa.high:.1f})"
        )


class FirstModeMeasurement:
    """One at a time."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._last: Measuring | None = None

    async def start(self, body: FirstModeBody, permit: Permit) -> FirstModeState:
        """Begin; CommandRefused while one runs and unless the rig holds or follows, ParameterError for too far."""
        self._require_ready()
        parameters = self._parts.procedures.context.rig.require_info().parameters
        torque = await self._parts.planner.do(planning.torque, body.travel, parameters)
        self._require_ready()
        permit.require(Request.FOLLOW)
        last = self._last = Measuring(self._parts, body, torque, permit)
        self._parts.procedures.start(last, f", {2 * body.repeats} steps")
        return last.view()

    def stop(self, permit: Permit) -> FirstModeState:
        """End it, and hold; raises CommandRefused when none runs."""
        if self._last is None or not self._last.running:
            raise CommandRefused("no first mode is being measured")
        self._last.end(f"stopped by {permit.name}")
        return self._last.view()

    def state(self) -> FirstModeState | None:
        """How the last one goes, or ended; None before the first."""
        return self._last.view() if self._last else None

    def _require_ready(self) -> None:
        if self._last is not None and not self._last.over:
            raise CommandRefused("the first mode is being measured already; stop that first")
        newest = require_mode(
            self._parts.procedures.context.rig,
            (Mode.HOLD, Mode.FOLLOW),
            lambda mode: f"the first mode is measured from HOLD or FOLLOW, and the rig is in {words(mode)}",
        )
        if not np.isfinite(newest["p_meas"]).all():
            raise CommandRefused("the first mode is measured at the tip, whose marker is not seen")


GivenMeasurement = Annotated[FirstModeMeasurement, given(FirstModeMeasurement)]
