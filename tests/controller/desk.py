"""A rig alone, ticked by hand: the test is its clock, its markers, its server and its operator."""

from typing import Any

import numpy as np

from controller.assembly.rig import build_rig
from controller.kernels.control.tick import tick
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, LoopStatus, Measurement, Telemetry
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import RigParameters, Settings

BOOT, MS = 7, 1_000_000
HUM = 1e-9
"""No two samples of a camera are the same [m]."""


class Desk:
    """Whatever is set to False or None here is missing in the next steps."""

    def __init__(self, parameters: RigParameters | None = None, **settings: Any) -> None:
        self.rig = build_rig(parameters or RigParameters(), BOOT)
        self.command = to_record(Command(boot=BOOT, settings=Settings(**settings)))
        self.measurement, self.status = to_record(Measurement()), to_record(LoopStatus())
        self.telemetry = np.zeros(1, record_dtype(Telemetry))
        self.now = 10_000 * MS
        self.operator = self.server = self.pump = self.camera = self.air = True
        self.still = False
        """The camera repeats its numbers."""
        self.leak = np.zeros(4)
        """What the pressure sensors show beyond what is in the chambers [Pa]."""
        x = 0.0253 * np.arange(1, 11)
        self.markers = np.column_stack([x, np.zeros(10)])

    def step(self, milliseconds: int = 1, gap: int = 1) -> np.void:
        """Tick once every `gap` ms for so long; returns the last row."""
        for _ in range(max(milliseconds // gap, 1)):
            self.now += gap * MS
            self.command["presence"] += self.operator
            if self.server:
                self.status["server_ns"] = self.now
            if self.pump:
                self.status["pump_ns"] = self.now
            if self.camera:
                self.measurement["t_ns"] = self.now - MS
                hum = HUM * (self.measurement["markers"][0, 0, 0] == self.markers[0, 0] and not self.still)
                self.measurement["markers"] = self.markers + hum
            row = self.telemetry[0]
            tick(self.now, self.command[0], self.measurement[0], self.status[0], self.rig, row)
            if self.air:
                differences = self.rig.observer.u_hat * self.rig.control.pascal_per_torque[::2]
                self.measurement["pressures"] = (
                    np.column_stack([differences, -differences]).clip(min=0.0).ravel() + self.leak
                )
        return row

    def ask(self, request: int, **fields: Any) -> np.void:
        self.command["request_n"] += 1
        self.command["request"] = request
        for name, value in fields.items():
            self.command[name] = value
        return self.step()

    def settings(self, **settings: Any) -> None:
        self.command["settings"] = to_record(Settings(**settings))

    def plan(self, rows: np.ndarray, again: int = 0, ticks: int | None = None) -> None:
        """Put a reference for TRACK in place."""
        self.rig.control.reference[: len(rows)], self.rig.control.guide[: len(rows)] = rows, np.nan
        self.rig.control.plan[0] = len(rows), again, len(rows) if ticks is None else ticks

    def into(self, mode: Mode) -> None:
        """Bring the rig into `mode` by the requests that an operator would make."""
        self.plan(np.tile([0.25, 0.01], (60_000, 1)))
        self.step(20)
        for request in ROUTES[mode]:
            self.ask(request)
        if mode == Mode.REST:
            self.rig.control.state["u"] = 0.01
            self.ask(Request.REST)
        if mode == Mode.FAULT:
            self.rig.control.state["mode"] = Mode.FAULT
            self.step()
        assert self.mode == mode

    @property
    def mode(self) -> Mode:
        return Mode(int(self.telemetry["mode"][0]))

    @property
    def cause(self) -> Cause:
        return Cause(int(self.telemetry["cause"][0]))


ROUTES = {
    Mode.VENTED: [],
    Mode.HOLD: [Request.ARM],
    Mode.FOLLOW: [Request.ARM, Request.FOLLOW],
    Mode.TRACK: [Request.ARM, Request.TRACK],
    Mode.REST: [Request.ARM],
    Mode.FAULT: [Request.ARM],
    Mode.E_STOP: [Request.E_STOP],
}
