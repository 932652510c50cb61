"""Every parameter, once: unit, bounds and symbol beside the number. SI units, plane frame of the paper.

Live settings (`Settings`) travel in every command; the rest is fixed while a rig process runs.
"""

from typing import Annotated, Any, Literal, Self

from pydantic import Field as Bounds
from pydantic import model_validator

from controller.errors import ParameterError
from controller.schema.actuator import PRESETS, U_MAX_LEAST, Actuator, is_of_paper
from controller.schema.fit import GAINS, TWIN
from controller.schema.hardware import Hardware
from controller.schema.layout import Model
from controller.schema.layout import Quantity as Q
from controller.schema.modes import Integrator, Law
from controller.schema.slot import TUNING

SENSORS = 10
"""Sensor positions along the backbone. Sensor i sits at arc length i L / 10, so "rod 6" of the paper is the distal end
of rod 6 of 10 and "rod 10" the tip, whatever the number of rods in the model."""

BACKBONE_POINTS = 21
"""Backbone samples in telemetry, at arc lengths j L / 20: every second one is a sensor position."""

REFERENCE_ROWS = 300_000
"""Room for a planned reference: 5 minutes at 1 kHz."""

DT = 1e-3
"""Period of the loop unless it is started with another, and of the rows of every reference [s]."""

Gain = Annotated[float, Bounds(ge=0.0, le=5.0)]
IntegralGain = Annotated[float, Bounds(ge=0.0, le=20.0)]
VelocityGain = Annotated[float, Bounds(ge=0.0, le=1.0)]
OBSERVER_GAIN_MAX, OBSERVER_DAMPING_MAX = 500.0, 5.0
"""With every K_o [N/m] and B_o [N s/m] up to these the observer is stable, but for what RK4 with few or light rods
cannot hold (`RigInfo.observer_gains_max`)."""
OBSERVER_KAPPA = (1.0, 100.0)
"""Bounds of the observer's kappa: of the table's inertia, and of a first mode at some 5 Hz."""
ObserverKappa = Annotated[float, Bounds(ge=OBSERVER_KAPPA[0], le=OBSERVER_KAPPA[1])]
ObserverGain = Annotated[float, Bounds(ge=0.0, le=OBSERVER_GAIN_MAX)]
ObserverDamping = Annotated[float, Bounds(ge=0.0, le=OBSERVER_DAMPING_MAX)]
KAPPA = (0.1, 500.0)
"""Bounds of the twin's kappa: a body of a tenth of the table's stiffness over inertia, or of 500 times as much."""
TWIN_RODS_MAX = 100
Mismatch = Annotated[float, Bounds(ge=0.5, le=2.0)]
Imbalance = Annotated[float, Bounds(ge=-0.5, le=0.5)]
Set = Annotated[float, Bounds(ge=-10.0, le=10.0)]
Share = Annotated[float, Bounds(ge=0.0, le=10.0)]
Relaxation = Annotated[float, Bounds(ge=1e-3, le=1e4)]
PlantKind = Literal["rod", "cosserat"]
PairLag = Annotated[float, Bounds(ge=0.0, le=0.5)]
PairLoop = Annotated[float, Bounds(ge=0.0, le=0.5)]
Torque = Annotated[float, Bounds(ge=-0.2, le=0.2)]


class Settings(Model):
    """What an operator changes live. Gains are the diagonals of the paper's 2x2 matrices."""

    law: Law = Law.FF_PI
    controller: Annotated[int, Bounds(ge=0, le=255), Q("1")] = 0
    """Which of the rig's controllers is in the slot (`RigInfo.controllers`); it changes in HOLD, not on the way."""
    tuning: Annotated[tuple[float, ...], Q("1", shape=(TUNING,)), Bounds(min_length=TUNING, max_length=TUNING)] = (
        0.0,
    ) * TUNING
    """The controller's own numbers, in the order of its definition; 0 beyond them."""
    sensed: Annotated[int, Bounds(ge=0, lt=2**SENSORS), Q("1", "sensors")] = 1 << (SENSORS - 1)
    """Bit i-1 set: the observer uses the marker of rod i. Only the tip by default."""
    K_P: Annotated[tuple[Gain, Gain], Q("1", "K_P", (2,))] = (GAINS["K_P"],) * 2
    K_I: Annotated[tuple[IntegralGain, IntegralGain], Q("1/s", "K_I", (2,))] = (GAINS["K_I"],) * 2
    K_FF: Annotated[tuple[VelocityGain, VelocityGain], Q("s", "K_FF", (2,))] = (0.0, 0.0)
    """Velocity feedforward: off by default, as in the paper's Task 5 (live reference)."""
    K_o: Annotated[tuple[ObserverGain, ObserverGain], Q("N/m", "K_o", (2,))] = (400.0, 400.0)
    """Ours, with B_o; paper: 100 and 0. The markers' noise is the prediction's to take away (docs/observer.md)."""
    B_o: Annotated[tuple[ObserverDamping, ObserverDamping], Q("N s/m", "B_o", (2,))] = (0.5, 0.5)
    feedforward_period: Annotated[float, Bounds(ge=0.001, le=0.1), Q("s", "T_ff")] = 0.001
    """How often the quasi-static inverse is solved; the paper's Task 5 uses 0.01 s."""
    speed_max: Annotated[float, Bounds(ge=0.001, le=1.0), Q("m/s", "v_max")] = 0.2
    """Speed limit of a live target in FOLLOW."""
    acceleration_max: Annotated[float, Bounds(ge=0.01, le=10.0), Q("m/s^2", "a_max")] = 1.5
    u_open: Annotated[tuple[Torque, Torque], Q("N m", "u", (2,))] = (0.0, 0.0)
    """Command in the OPEN_LOOP law; approached at `torque_rate_max`, saturated like any other."""


REPEATING = Settings(K_FF=(GAINS["K_FF"],) * 2)
"""The gains as they are at the start, and the fit's velocity feedforward: the paper has it on in its Task 2."""


class ControllerParameters(Model):
    """Fixed numbers of the loop. The paper's where it gives them, ours (marked) where it does not."""

    dt: Annotated[float, Bounds(ge=1e-4, le=1e-2), Q("s", "dt")] = DT
    rods: Annotated[int, Bounds(ge=2, le=1000), Q("1", "N")] = 10
    integrator: Integrator = Integrator.IMPLICIT
    """The paper has RK4, which is refused where it is not stable with `dt`: at 1 ms with more than some 10 rods."""
    observer_beta: Annotated[float, Bounds(ge=0.0, le=1.0), Q("s", "beta_o")] = 0.05
    """Least damping over stiffness of the observer's hinges beyond the last sensed point (ours; paper: 0), where no
    virtual spring reaches (docs/observer.md). RK4 could not hold it and has none."""
    observer_kappa: Annotated[ObserverKappa, Q("1", "kappa_o")] = 1.0
    """Inertia of the actuator's table over that of the observer's body, as it was measured (ours; paper: 1): statics
    and damping ratios stay, motions are kappa_o^(1/2) times as fast (docs/observer.md)."""
    omega_B: Annotated[float, Bounds(ge=0.0, le=1000.0), Q("rad/s", "omega_B")] = 100.0
    """Baumgarte frequency (ours; the paper gives none)."""
    zeta_B: Annotated[float, Bounds(ge=0.0, le=10.0), Q("1", "zeta_B")] = 1.0
    epsilon: Annotated[float, Bounds(gt=0.0, le=1e-2), Q("1", "epsilon")] = 1e-8
    rcond_min: Annotated[float, Bounds(gt=0.0, le=1e-2), Q("1", "rcond")] = 1e-10
    weak_ratio: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.2
    """Feedback fades in a direction in which S moves the tip less than this share of its strongest (ours; paper: 0).
    At the straight pose nothing can move the tip along x, and the paper's law alone saturates there on noise."""
    weak_ratio_live: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.35
    """The same but for the shapes of the library, which the arm is known to follow: where the tip may be led anywhere,
    by hand, on a drawn path or on the way to another pose, it meets the edge of the reach, a fold of S, and feedback
    that fades later swings over the whole stroke (ours)."""
    feedback_lag: Annotated[float, Bounds(ge=0.0, le=2.0), Q("s")] = 0.2
    """Time constant with which P follows the error in FOLLOW and HOLD (ours; paper: 0). It rolls P off below the arm's
    first mode, whose damping no one measured: with a damping ratio of 0.1 the paper's law swings."""
    full_gains_from: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.6
    """Arc length of the outermost marker, as a share of the body, from which P and I have their gains in FOLLOW and
    HOLD; nearer to the base they have its square's share, at least `least_gains` (ours; paper: 0, in full by any)."""
    least_gains: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.25
    """Share of P and I by any marker there (ours): with less a constant error is removed too slowly."""
    carry_on: bool = True
    """The observer carries a marker on with its last velocity for as long as the sample is old (ours): held, it would
    lag by some 9 ms, 2 mm on the 1 Hz circle. The feedback's error is that of the held marker, as in the paper."""
    predict: bool = True
    """It carries a marker on with what its model does by itself, and with its last velocity only what the model does
    not explain, filtered as the marker's noise asks for (ours; docs/observer.md). Off where markers are held."""
    measured_torques: bool = True
    """It is driven by the measured pressures until their watchdog finds them broken (ours; paper: by what was sent,
    through `dead_time` and `pneumatic_lag`)."""
    dead_time: Annotated[float, Bounds(ge=0.0, le=0.2), Q("s", "t_d")] = 0.05
    pneumatic_lag: Annotated[float, Bounds(gt=0.0, le=1.0), Q("s", "tau")] = 0.05
    torque_rate_max: Annotated[float, Bounds(gt=0.0, le=10.0), Q("N m/s", "u_dot_max")] = 0.5
    """Bound on the rate of u_ff at a change of branch, and of u in OPEN_LOOP (ours)."""
    rest_rate: Annotated[float, Bounds(gt=0.0, le=1.0), Q("N m/s", "u_dot_rest")] = 0.03
    """Rate at which u is brought to zero in REST and FAULT (ours)."""
    torque_slew_max: Annotated[float, Bounds(gt=0.0, le=100.0), Q("N m/s")] = 5.0
    """Bound on the rate of u in HOLD and FOLLOW, feedback and all (ours), and of what holds a planned reference."""
    reference_K_FF: Annotated[VelocityGain, Q("s", "K_FF")] = GAINS["K_FF"]
    """K_FF of the library's references that the paper ran with it, where the settings have 0."""
    reference_speed_max: Annotated[float, Bounds(gt=0.0, le=100.0), Q("m/s")] = 1.0
    """No planned reference that does not declare steps is faster (ours: what settings may allow)."""
    reference_acceleration_max: Annotated[float, Bounds(gt=0.0, le=1000.0), Q("m/s^2")] = 25.0
    """The same for its acceleration over 20 ms (ours: the paper's 2 Hz circle sets in at once, with 19 m/s^2)."""


def usual_kappa(actuator: Actuator, integrator: Integrator) -> float:
    """`observer_kappa` before anybody has measured it: of the paper's actuators the fit's, of others the table's, 1.

    With the paper's RK4 it is the paper's, 1: with a faster body it would not be stable.
    """
    fitted = integrator == Integrator.IMPLICIT and is_of_paper(actuator)
    return float(TWIN["kappa"]) if fitted else 1.0


class SafetyLimits(Model):
    """Watchdog times and limits (docs/safety.md); every age is measured on the loop's own clock."""

    operator_timeout: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.5
    server_hold: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.5
    server_rest: Annotated[float, Bounds(gt=0.0, le=600.0), Q("s")] = 30.0
    pump_hold: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.5
    pump_rest: Annotated[float, Bounds(gt=0.0, le=60.0), Q("s")] = 2.0
    measurement_old: Annotated[float, Bounds(gt=0.0, le=1.0), Q("s")] = 0.05
    measurement_lost: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.5
    loop_gap: Annotated[float, Bounds(gt=0.0, le=1.0), Q("s")] = 0.05
    error_max: Annotated[float, Bounds(gt=0.0, le=1.0), Q("m")] = 0.08
    error_time: Annotated[float, Bounds(gt=0.0, le=60.0), Q("s")] = 2.0
    error_rms_max: Annotated[float, Bounds(gt=0.0, le=1.0), Q("m")] = 0.12
    """About its mean: a constant error is that of `error_max`."""
    error_rms_time: Annotated[float, Bounds(ge=0.1, le=60.0), Q("s")] = 1.0
    """Window of the mean and of the mean square."""
    swing_max: Annotated[float, Bounds(gt=0.0, le=1.0), Q("m")] = 0.025
    """Of the error, while the reference stands still: an amplitude of 35 mm."""
    swing_time: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.3
    """A tick counts as many times as the mean square is beyond its bound: a wide swing is stopped sooner."""
    swing_ratio: Annotated[float, Bounds(ge=0.0, le=100.0), Q("1")] = 2.5
    """As much more is allowed for each metre by which the reference itself swings (root of the sum of squares)."""
    residual_max: Annotated[float, Bounds(gt=0.0, le=1.0), Q("m")] = 0.04
    residual_time: Annotated[float, Bounds(gt=0.0, le=60.0), Q("s")] = 1.0
    jump_max: Annotated[float, Bounds(gt=0.0, le=1.0), Q("m")] = 0.03
    """A marker that leaves its own course, and the model's, by more than this since it was seen last is not used."""
    jump_speed: Annotated[float, Bounds(ge=0.0, le=10.0), Q("m/s")] = 0.5
    """Added to jump_max for the time since then."""
    frozen_time: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.2
    frozen_torque: Annotated[float, Bounds(gt=0.0, le=0.2), Q("N m")] = 0.003
    speed_max: Annotated[float, Bounds(gt=0.0, le=100.0), Q("m/s")] = 20.0
    """Five times as fast as a step of the paper: beyond, gains make the observer diverge. With
    `observer_kappa` its root as much: so much faster is the same body."""
    pressure_off_max: Annotated[float, Bounds(gt=0.0, le=1e6), Q("Pa")] = 30e3
    pressure_off_time: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.3
    pressures_lost: Annotated[float, Bounds(gt=0.0, le=10.0), Q("s")] = 0.1
    """Hardware alone: a board that is silent for longer has no pressures, and its own watchdog vents it."""
    pressure_max: Annotated[float, Bounds(gt=0.0, le=1e6), Q("Pa")] = 340e3
    """A measured chamber pressure above this is an E-STOP."""
    pressure_min: Annotated[float, Bounds(ge=-1e5, lt=0.0), Q("Pa")] = -20e3
    """So is one below this: gauge pressure, so a sensor or its wire is broken."""


class CosseratParameters(Model):
    """What the Cosserat plant has of its own (ours: neither the paper nor an actuator's file gives any of it)."""

    elements: Annotated[int, Bounds(ge=20, le=100, multiple_of=20), Q("1", "n")] = 20
    """Of the rod; multiples of 20, so that markers and backbone points are points of its grid."""
    stretch: Annotated[float, Bounds(ge=50.0, le=1e8), Q("1")] = 850.0
    """Stiffness to stretch, EA L^2 / EI: 12 (L / width)^2 of a solid section, 850 for P1."""
    shear: Annotated[float, Bounds(ge=20.0, le=1e8), Q("1")] = 240.0
    """Stiffness to shear, GA L^2 / EI: 5/6 of a third of that of stretch, as of a rectangle of rubber."""
    viscosity: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.5
    """Share of the first mode's damping that is the material's, by stiffness; the rest is by mass."""
    stiffening: Annotated[float, Bounds(ge=0.0, le=3.0), Q("1")] = 0.3
    """Bending stiffness that a pair adds along its half when its pressures sum up to that of u_max, as a share."""
    torque_gain: Annotated[tuple[Mismatch, Mismatch], Q("1", shape=(2,))] = (1.0, 1.0)
    """As the twin's, whose fitted ones would hide a part of what pressure stiffens."""
    chamber_imbalance: Annotated[tuple[Imbalance, Imbalance], Q("1", shape=(2,))] = (0.0, 0.0)
    """As the twin's."""
    set_curvature: Annotated[tuple[Set, Set], Q("1/m", shape=(2,))] = (0.0, 0.0)
    """As the twin's."""
    lag: Annotated[tuple[PairLag, PairLag], Q("s", shape=(2,))] = (0.005, 0.01)
    """First-order lag from each pair's pressures to its torque, behind valves and lines."""
    pair_hysteresis: Annotated[tuple[PairLoop, PairLoop], Q("1", shape=(2,))] = (0.01, 0.015)
    """By how much each pair's torque stays behind its pressures, either way, as a share of u_max."""


class TwinParameters(Model):
    """The simulated actuator: the same static map as the model, another time scale, and honest flaws (docs/model.md).

    The defaults are of the paper's three; `usual_twin` has those of any other. A Cosserat plant uses them too, but for
    those in `ROD_ONLY`.
    """

    plant: PlantKind = "rod"
    """A chain of rigid rods, as the model is one, or a Cosserat rod (docs/model.md)."""
    cosserat: CosseratParameters = CosseratParameters()
    rods: Annotated[int, Bounds(ge=2, le=TWIN_RODS_MAX), Q("1", "N")] = 14
    integrator: Integrator = Integrator.IMPLICIT
    """One implicit step a tick takes any stiffness; RK4, in as many substeps as it needs, takes three times as long."""
    substeps: Annotated[int, Bounds(ge=1, le=20), Q("1")] = 4
    """Of RK4 in a tick, at least."""
    kappa: Annotated[float, Bounds(ge=KAPPA[0], le=KAPPA[1]), Q("1", "kappa")] = TWIN["kappa"]
    """Stiffness and torque gain are scaled together: the static map stays, the first mode of P1 rises to 3.1 Hz, or to
    3.5 Hz in small motions, in which creep and hysteresis stiffen it. 1: the mass and stiffness of the file."""
    zeta: Annotated[float, Bounds(ge=0.0, le=2.0), Q("1", "zeta")] | None = TWIN["zeta"]
    """Damping ratio of the first mode; none: b and alpha as the actuator has them."""
    stiffness_scale: Annotated[float, Bounds(ge=0.5, le=2.0), Q("1")] = 1.0
    torque_gain: Annotated[tuple[Mismatch, Mismatch], Q("1", shape=(2,))] = TWIN["torque_gain"]
    """Deliberate mismatch: each pair bends the plant this much more than the model believes."""
    chamber_imbalance: Annotated[tuple[Imbalance, Imbalance], Q("1", shape=(2,))] = TWIN.get(
        "chamber_imbalance", (0.0, 0.0)
    )
    """By which share the first chamber of each pair bends the plant more than `torque_gain` says, and the second less:
    with it the four chambers of a print have four gains, as a `pressure_map` of four has four slopes."""
    set_curvature: Annotated[tuple[Set, Set], Q("1/m", shape=(2,))] = TWIN["set_curvature"]
    """What the base half and the tip half are bent at rest, unknown to the model: TPU keeps some of past bends."""
    creep: Annotated[tuple[Share, Share], Q("1", "g", (2,))] = TWIN["creep"]
    """Share of the stiffness in each of two Maxwell branches (TPU creep)."""
    creep_time: Annotated[tuple[Relaxation, Relaxation], Q("s", "tau_m", (2,))] = TWIN["creep_time"]
    friction: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1", "mu")] = TWIN["friction"]
    """Coulomb friction on the PTFE sheet; it sticks."""
    slip: Annotated[float, Bounds(ge=1e-5, le=1e-2), Q("m")] = 5e-4
    """Way over which friction on the sheet builds up and turns round (ours)."""
    hysteresis: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = TWIN["hysteresis"]
    """Stiffness that the hysteresis of TPU adds to small motions, as a share of the stiffness."""
    hysteresis_bend: Annotated[float, Bounds(ge=0.01, le=6.0), Q("rad")] = TWIN["hysteresis_bend"]
    """Change of the whole backbone's bend over which the hysteresis builds up and turns round."""
    inflate_time: Annotated[float, Bounds(ge=0.005, le=1.0), Q("s")] = TWIN["inflate_time"]
    """What the gain of the pressure loops is chosen for while they fill: the lag of a small step."""
    exhaust_time: Annotated[float, Bounds(ge=0.005, le=1.0), Q("s")] = TWIN["exhaust_time"]
    """The same while they exhaust, at 60 kPa; below and for large steps air leaves more slowly."""
    supply_pressure: Annotated[float, Bounds(ge=1e5, le=1e6), Q("Pa")] = 600e3
    """Gauge (ours; the paper gives none). No chamber is filled beyond."""
    conductance: Annotated[float, Bounds(ge=1e-10, le=1e-7), Q("m^3/(s Pa)", "C")] = 3.9e-9
    """Sonic conductance (ISO 6358) of a valve (ours): about 100 l/min from 6 to 5 bar, unchecked with a data sheet."""
    critical_ratio: Annotated[float, Bounds(ge=0.0, le=0.6), Q("1", "b")] = 0.3
    """Pressure ratio below which the flow is choked (ours: usual for spool valves; an ideal nozzle has 0.528)."""
    chamber_volume: Annotated[float, Bounds(ge=1e-6, le=1e-3), Q("m^3", "V")] = 5e-5
    """Of a chamber, 126 x 20 x 10 mm inside, and 2 m of line of 4 mm (ours: the paper gives neither)."""
    valve_lag: Annotated[float, Bounds(ge=0.0, le=0.1), Q("s")] = 1.3e-3
    """Of the spool (ours): first order at about 125 Hz."""
    valve_offset: Annotated[float, Bounds(ge=-0.01, le=0.01), Q("1")] = 0.004
    """The spool's rest position off its middle, as a share of the stroke (ours): what the loops' integral is for."""
    valve_integral_time: Annotated[float, Bounds(ge=0.1, le=10.0), Q("s")] = 0.2
    """Reset time of the pressure loops (ours)."""
    dead_time: Annotated[float, Bounds(ge=0.0, le=0.2), Q("s")] = 0.05
    marker_noise: Annotated[float, Bounds(ge=0.0, le=0.01), Q("m")] = 1e-4
    marker_period: Annotated[float, Bounds(ge=1e-3, le=1.0), Q("s")] = 0.01
    marker_latency: Annotated[float, Bounds(ge=0.0, le=0.1), Q("s")] = 0.004
    seed: Annotated[int, Bounds(ge=0, le=2**31 - 1), Q("1")] = 0


ROD_ONLY = (
    "rods",
    "integrator",
    "substeps",
    "torque_gain",
    "chamber_imbalance",
    "set_curvature",
    "creep",
    "creep_time",
    "hysteresis",
    "hysteresis_bend",
)
"""Of `TwinParameters` what a Cosserat plant does not use."""


AS_IN_FILE: dict[str, Any] = {
    "kappa": 1.0,
    "zeta": None,
    "torque_gain": (1.0, 1.0),
    "chamber_imbalance": (0.0, 0.0),
    "set_curvature": (0.0, 0.0),
    "creep": (0.0, 0.0),
    "friction": 0.0,
    "hysteresis": 0.0,
}
"""The twin of an actuator of which no more is known than its file says: what was fitted to the paper is not its own."""


def usual_twin(actuator: Actuator, given: TwinParameters | None = None) -> TwinParameters:
    """The twin of `actuator`: of the paper's three as fitted to it, of any other as its file says.

    Fields of `given` that were set are kept. The chain of a file without EI is that of its table.
    """
    given = given or TwinParameters()
    if is_of_paper(actuator):
        return given
    rods = {} if actuator.EI is not None else {"rods": min(actuator.table_rods, TWIN_RODS_MAX)}
    own = {name: value for name, value in (AS_IN_FILE | rods).items() if name not in given.model_fields_set}
    found = given.model_copy(update=own)
    found.__pydantic_fields_set__.difference_update(own)
    return found


class RigParameters(Model):
    """Everything a rig process is started with. What `twin` leaves out is what is usual for the body it stands for."""

    actuator: Actuator = PRESETS["P1"]
    controller: ControllerParameters = ControllerParameters()
    limits: SafetyLimits = SafetyLimits()
    twin: TwinParameters = TwinParameters()
    plant_actuator: Actuator | None = None
    """What is simulated, where it is another body than the one that observer and controller believe in."""
    hardware: Hardware | None = None
    """A rig that is not simulated: its motion capture and its valves. None: the twin stands in for it."""

    def with_actuator(self, actuator: Actuator) -> Self:
        """The same rig with `actuator`, which is asked for no more torque than its valves may make.

        So `valves.pressure_max` bounds reach, reference and observer too: a setpoint that is cut behind their back is a
        PRESSURE_MISMATCH. Raises ParameterError where no usable torque is left.
        """
        return self._bounded(actuator)._with_usual_twin(self.body)

    @property
    def body(self) -> Actuator:
        """The actuator that is simulated."""
        return self.plant_actuator or self.actuator

    @model_validator(mode="after")
    def _twin_of_body(self) -> Self:
        self.__dict__["twin"] = usual_twin(self.body, self.twin)
        return self

    def _with_usual_twin(self, before: Actuator) -> Self:
        """The same with what was usual for `before` in the twin as it is usual for the body of now."""
        was, now = usual_twin(before), usual_twin(self.body)
        names = [name for name in TwinParameters.model_fields if getattr(self.twin, name) == getattr(was, name)]
        twin = self.twin.model_copy(update={name: getattr(now, name) for name in names})
        return self.model_copy(update={"twin": twin})

    def _bounded(self, actuator: Actuator) -> Self:
        if self.hardware is None:
            return self.model_copy(update={"actuator": actuator})
        pressure_max = self.hardware.valves.pressure_max
        u_max = min(actuator.u_max, pressure_max / max(actuator.pressure_map))
        if u_max < U_MAX_LEAST:
            raise ParameterError(
                f"valves.pressure_max = {pressure_max:g} Pa makes u_max = {u_max:.3g} N m of actuator {actuator.name}, "
                f"below {U_MAX_LEAST:g}"
            )
        return self.model_copy(update={"actuator": actuator.model_copy(update={"u_max": u_max})})
