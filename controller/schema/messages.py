"""Every message between processes, once. `Command` and `Telemetry` are records (layout.py); the rest is JSON.

All times inside a record are nanoseconds of the rig's monotonic clock: no two machines' clocks are ever compared.
"""

from datetime import datetime
from typing import Annotated

from pydantic import Field as Bounds

from controller.schema.layout import Model
from controller.schema.layout import Quantity as Q
from controller.schema.modes import Cause, Freeze, Mode, Request
from controller.schema.parameters import (
    BACKBONE_POINTS,
    OBSERVER_DAMPING_MAX,
    OBSERVER_GAIN_MAX,
    SENSORS,
    RigParameters,
    Settings,
)
from controller.schema.slot import SIGNALS

Pair = Annotated[tuple[float, float], Q("m", shape=(2,))]
Torques = Annotated[tuple[float, float], Q("N m", shape=(2,))]
Chambers = Annotated[tuple[float, float, float, float], Q("Pa", shape=(4,))]
Sensors = Annotated[list[tuple[float, float]], Q("m", shape=(SENSORS, 2))]
Backbone = Annotated[list[tuple[float, float]], Q("m", shape=(BACKBONE_POINTS, 2), storage="<f4")]
Signals = Annotated[list[float], Q("1", shape=(SIGNALS,))]
Coordinate = Annotated[float, Bounds(ge=-2.0, le=2.0)]
Jump = Annotated[float, Bounds(ge=-0.2, le=0.2)]
STEPS_MAX = 10_000
"""Most ticks that a paused twin takes at once: 10 s at 1 kHz."""
ChamberBits = Annotated[int, Bounds(ge=0, lt=2**4), Q("1")]


NUMBER_MAX = 2**62
"""Largest number that a command may bear: what is added to one never leaves the 64 bits of a record."""
Number = Annotated[int, Bounds(ge=0, le=NUMBER_MAX)]


class Command(Model):
    """The whole desired state, numbered; always written as one. Repeating it is harmless."""

    n: Number = 0
    """Number of this command; telemetry echoes the number in force."""
    boot: Number = 0
    """Boot id of the rig it is meant for; a request for another boot is refused."""
    request_n: Number = 0
    """Edge counter: the request is acted on once, when this number rises."""
    request: Request = Request.NONE
    presence: Number = 0
    """Advanced only by the operator's own page or client; only a value above all before it is presence."""
    unattended: Annotated[int, Bounds(ge=0, le=1)] = 0
    """1: a TRACK run may finish without an operator."""
    commissioning: Annotated[int, Bounds(ge=0, le=1)] = 0
    """1: a step of the commissioning asks, which may arm devices that are not commissioned yet, in open loop."""
    target: Annotated[tuple[Coordinate, Coordinate], Q("m", "p_target", (2,))] = (0.0, 0.0)
    settings: Settings = Settings()


class Measurement(Model):
    """What the plant (driver or twin) gives the tick: held between samples, with the time of capture."""

    t_ns: int = 0
    """Clock time at which the markers were captured; 0 when there was none yet."""
    markers: Sensors = [(0.0, 0.0)] * SENSORS
    """Marker positions at the sensors' arc lengths; nan where a marker is not seen."""
    pressures: Chambers = (0.0, 0.0, 0.0, 0.0)
    pressures_ns: int = 0
    """Clock time at which the pressures were read; 0: in this very tick, as a simulated plant shows them."""


class ValveCommand(Model):
    """What the loop wants of a rig's valves: a record that the valves' driver takes from a mailbox, newest whole."""

    t_ns: int = 0
    """Clock at the start of the tick that made it."""
    vent: int = 1
    """1: every chamber is to be open to the atmosphere."""
    cut: int = 0
    """1, in E_STOP: the supply is to be cut, too."""
    pressures: Chambers = (0.0, 0.0, 0.0, 0.0)
    """Setpoints within the limits of the rig file."""
    openings: Annotated[tuple[float, float, float, float], Q("1", shape=(4,))] = (0.0, 0.0, 0.0, 0.0)
    """-1 (exhausts) to 1 (fills); from our own pressure loop, for raw valves."""


class Telemetry(Model):
    """One tick, completely: what was sensed, estimated, wanted and sent, when, and in which state."""

    tick: int
    """Ticks executed since the rig started."""
    slot: int
    """Index on the time grid; slots without a tick were lost."""
    t_ns: Annotated[int, Q("ns")]
    """Clock at the start of the tick."""
    mode: Mode
    cause: Cause
    command_n: int
    """Number of the command in force."""
    request_n: int
    """Last request looked at."""
    request_cause: Cause
    """NONE: that request was accepted; else why it was refused."""
    presence: int
    lost: int
    """Slots lost so far."""
    law: int
    controller: int
    """In force, as in `RigInfo.controllers`."""
    sensed: int
    """Sensors used in this tick: switched on, fresh and finite (bit i-1 for rod i)."""
    lateness_ns: Annotated[int, Q("ns")]
    """Wake-up after the deadline."""
    step_ns: Annotated[int, Q("ns")]
    """Duration of the previous tick, plant excluded."""
    measurement_age: Annotated[float, Q("s")]
    operator_age: Annotated[float, Q("s")]
    server_age: Annotated[float, Q("s")]
    target: Annotated[Pair, Q("m", "p_target", (2,))]
    """Target in force, as commanded."""
    p_ref: Annotated[Pair, Q("m", "p_ref", (2,))]
    """Reference after speed limit and projection into the reach."""
    p_ref_dot: Annotated[Pair, Q("m/s", "p_ref'", (2,))]
    p_meas: Annotated[Pair, Q("m", "p_data", (2,))]
    """Measured tip; nan when its marker is not seen."""
    p_hat: Annotated[Pair, Q("m", "p_model", (2,))]
    """Observer's tip."""
    error: Annotated[Pair, Q("m", "e", (2,))]
    """p_ref - tip, the tip measured where it is sensed, else the observer's."""
    integral: Annotated[Pair, Q("m s", "int e", (2,))]
    """Of the error; where the tip is led by hand what the paper's law would need for the torque that is kept."""
    residual: Annotated[float, Q("m")]
    """RMS over the sensed rods of |measured - observer|; nan when none is sensed."""
    u_ff: Annotated[Torques, Q("N m", "u_FF", (2,))]
    u_fb: Annotated[Torques, Q("N m", "u_FB", (2,))]
    u: Annotated[Torques, Q("N m", "u", (2,))]
    """Saturated sum: what was sent."""
    signals: Annotated[Signals, Q("1", shape=(SIGNALS,))]
    """What the controller shows, in the order and units of its definition."""
    u_hat: Annotated[Torques, Q("N m", shape=(2,))]
    """The observer's delayed and lagged input."""
    saturated: int
    """1: the sum was clamped in this tick, and the integral was held."""
    reachable: int
    """0: the target is out of reach and p_ref is the nearest reachable point."""
    pressure_cmd: Annotated[Chambers, Q("Pa", shape=(4,))]
    pressure_meas: Annotated[Chambers, Q("Pa", shape=(4,))]
    energy: Annotated[float, Q("J", "H")]
    power: Annotated[tuple[float, float, float, float], Q("W", shape=(4,))]
    """Damping, pneumatic, observer and Baumgarte power (Eq. HDOT), in this order."""
    ledger: Annotated[float, Q("J")]
    """H minus the integral of the four powers since the start: the integrator's error."""
    markers: Sensors
    """Measured markers; nan where not seen, or not used because they jumped."""
    backbone: Backbone
    """Observer's backbone."""
    twin_backbone: Backbone
    """The twin's true backbone; nan on hardware."""
    reseats: int
    """Times that the observer was found wound and was set again from a static pose (kernels/observer/reseat.py)."""


class TwinFaults(Model):
    """What is injected into the twin beside its own flaws; off with every boot of the rig."""

    noise: Annotated[float, Bounds(ge=0.0, le=0.02), Q("m", "sigma")] = 0.0
    """Added standard deviation of each coordinate."""
    sample_loss: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.0
    """Probability that a sample of all markers is lost."""
    marker_loss: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.0
    """Probability that a marker is not seen in a sample."""
    rods: Annotated[int, Bounds(ge=0, lt=2**SENSORS), Q("1")] = 2**SENSORS - 1
    """Bit i-1 set: noise, jump and loss of markers meet rod i."""
    jump: Annotated[tuple[Jump, Jump], Q("m", shape=(2,))] = (0.0, 0.0)
    """By how much markers are measured beside where they are."""
    freeze: Freeze = Freeze.OFF
    """Samples of all markers repeat the last one."""
    sensors_stuck: ChamberBits = 0
    """Bit i set: the pressure sensor of chamber i (u1+, u1-, u2+, u2-) keeps its value, also for its valve's loop."""
    valves_stuck: ChamberBits = 0
    """Bit i set: the spool of chamber i stays where it is."""
    supply_lost: bool = False
    """The supply line is open to the atmosphere: all chambers empty, whatever is commanded."""


class TwinTime(Model):
    """The twin's time, which stands still while it is paused; the whole loop waits, observer and controller too."""

    paused: bool = False
    steps: Annotated[int, Bounds(ge=0, le=STEPS_MAX), Q("1")] = 0
    """Ticks to be taken at the loop's own rate before time stands still again; 0 unless paused."""


class CommandReply(Model):
    """The rig's answer to one command, after the loop has looked at it."""

    n: int
    accepted: bool
    mode: Mode
    cause: Cause
    detail: str
    """One sentence for the operator."""


class Latched(Model):
    """What a rig is latched by, as it is kept on its machine until a CLEAR (docs/safety.md)."""

    mode: Mode
    """FAULT or E_STOP."""
    cause: Cause
    by: str = ""
    """Who pressed, as the server knows its people; "" for a watchdog, or where nobody said."""
    at: datetime
    """When, by the clock of the rig's machine."""


class ControllerNumber(Model):
    """A number that a controller is tuned by."""

    name: str
    symbol: str
    unit: str
    usual: float
    """Where no other value is given."""
    low: float
    """Least that it takes."""
    high: float
    """Most that it takes."""
    about: str = ""


class ControllerSignal(Model):
    """A number that a controller shows."""

    name: str
    unit: str


class ControllerInfo(Model):
    """A controller that a rig has; `Settings.controller` counts them."""

    name: str
    title: str
    citation: str
    plans: bool
    """It follows torques that were planned along the reference (`PlannedRows.planned`)."""
    own_gains: bool
    """It takes no heed of K_P, K_I and K_FF."""
    tuning: list[ControllerNumber]
    """`Settings.tuning` has these, in this order."""
    signals: list[ControllerSignal]
    """`Telemetry.signals` has these."""
    refused: str = ""
    """Why the rig does not have it in its slot, after a trial on the twin; "" where it does."""


class RigInfo(Model):
    """Who the rig is: read once per connection and after every restart."""

    rig: str
    boot: int
    version: str
    commit: str = ""
    """Of its sources; "" if unknown, or where an older version recorded it."""
    layout: str
    """`layout_hash(Command, Telemetry)`; another value means another version."""
    wall_offset_ns: int
    """Unix time minus the rig's monotonic clock, at start: for time stamps of recordings only."""
    policy: str
    """Scheduling that the loop obtained: "SCHED_FIFO 50", "nice -15" or "none"."""
    twin: bool
    parameters: RigParameters
    observer_gains_max: tuple[float, float] = (OBSERVER_GAIN_MAX, OBSERVER_DAMPING_MAX)
    """Most K_o [N/m] and B_o [N s/m] with which its integrator is stable, whatever is sensed; it takes no more."""
    controllers: tuple[ControllerInfo, ...] = ()
    """What may be in its slot."""
    latched: Latched | None = None
    """What it is latched by at this moment, by an earlier boot of it or in this one."""

    @property
    def program(self) -> str:
        """As "Tendril 0.1.0 (commit 1a2b3c4)"."""
        return f"Tendril {self.version}" + (f" (commit {self.commit})" if self.commit else "")


class LoopStatus(Model):
    """What only the real-time loop knows, handed to every tick: a simulation fills it with a perfect loop."""

    server_ns: int = 0
    """Clock time at which the last command record arrived, repeated or not."""
    pump_ns: int = 0
    """Last heartbeat of the Python side of the rig process."""
    lateness_ns: int = 0
    step_ns: int = 0
    lost: int = 0
