"""An actuator as data: the paper's three, and the TOML file in which a user describes another (docs/actuators.md)."""

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from pydantic import BeforeValidator, ModelWrapValidatorHandler, model_validator
from pydantic import Field as Bounds

from controller.arrays import Array
from controller.errors import ParameterError, spelled
from controller.schema.layout import Model, quantity
from controller.schema.layout import Quantity as Q
from controller.schema.rigidity import joint_stiffness
from controller.text.toml import model_in

AXIS_MIN = 1e-6
"""A tracking axis shorter than this has no direction."""

BEYOND = 1.1
"""A tracked body farther out than this many lengths is a mistake, not a marker on a bracket."""

FOLDER = Path(__file__).parent / "actuators"
"""The paper's actuators, in the format of any other."""

T = TypeVar("T")


def _as_profile(value: Any) -> Any:
    """A bare number is a uniform profile."""
    return [value] if isinstance(value, int | float) else value


Profile = Annotated[tuple[T, ...], Bounds(min_length=1, max_length=1000), BeforeValidator(_as_profile)]
"""Values from base to tip: one (uniform), two (linear in between), or one for each of `table_rods`."""

UNKNOWN = 1.0
"""Stands for k and b until they are computed from EI."""
ROUNDING = 1e-9
"""Share by which a number that was written and read may differ."""
U_MAX_LEAST = 1e-4
"""Smallest torque limit of an actuator [N m]."""
LIGHTEST = 1e-3
"""Least mass of a body [kg]: a gram."""
STIFFER_MAX = 20.0
"""Most that pressure may add to a joint's stiffness, as a share of it."""
LONGER_MAX = 0.5
"""Most that pressure may add to a part's length, as a share of it."""
RATIO_MAX = 1e4
"""Largest over smallest value of a profile, and tip load over mass: beyond it the chain's equations lose digits."""

Rigidity = Annotated[float, Bounds(ge=1e-8, le=100.0)]
Arc = Annotated[float, Bounds(ge=0.0, le=2.0)]
STIFFNESS_MIN, STIFFNESS_MAX = 1e-5, 1e4
Stiffness = Annotated[float, Bounds(ge=STIFFNESS_MIN, le=STIFFNESS_MAX)]
Damping = Annotated[float, Bounds(ge=0.0, le=1e3)]
Density = Annotated[float, Bounds(ge=1e-3, le=1e3)]
Curvature = Annotated[float, Bounds(ge=-100.0, le=100.0)]
Acceleration = Annotated[float, Bounds(ge=-20.0, le=20.0)]
Stiffening = Annotated[float, Bounds(ge=0.0, le=1e-3)]
Stretching = Annotated[float, Bounds(ge=0.0, le=1e-4)]
PressureSlope = Annotated[float, Bounds(ge=1e4, le=1e9)]
PressureSlopes = Annotated[tuple[PressureSlope, ...], Bounds(min_length=2, max_length=4)]
Rod = Annotated[int, Bounds(ge=0, le=1000)]
ReplayGain = Annotated[float, Bounds(ge=0.0, le=1e5)]
ReplayDamping = Annotated[float, Bounds(ge=0.0, le=1e3)]
Coordinate = Annotated[float, Bounds(ge=-1e3, le=1e3)]
Product = Annotated[float, Bounds(allow_inf_nan=False)]


class Tracking(Model):
    """Where the tracked bodies of a recorded data file sit, and how its coordinates lie to the actuator."""

    base: Annotated[tuple[Coordinate, ...], Bounds(min_length=2, max_length=3), Q("m")]
    """The clamp in the file's coordinates."""
    axis: Annotated[tuple[Coordinate, ...], Bounds(min_length=2, max_length=3), Q("1")]
    """Direction of the backbone at the clamp, in the file's coordinates; any length but zero."""
    arcs: Annotated[tuple[Annotated[float, Bounds(gt=0.0, le=2.0)], ...], Bounds(min_length=1), Q("m", "s")]
    """Arc length of each tracked body."""
    principal: Annotated[tuple[Coordinate, ...], Q("1")] = ()
    """Direction of bending in which the actuator's k holds, in the file's coordinates; none: k holds in every one."""
    k_across: Annotated[Profile[Stiffness] | None, Q("N m/rad", "k")] = None
    """Joint stiffness for bending at right angles to `principal`, as many values as the actuator's k."""
    K_o: Annotated[tuple[ReplayGain, ReplayGain], Q("N/m", "K_o", (2,))] = (0.0, 0.0)
    """Gain of the offline observer along the body at rest and across it."""
    B_o: Annotated[tuple[ReplayDamping, ReplayDamping], Q("N s/m", "B_o", (2,))] = (0.0, 0.0)
    hold: tuple[Annotated[float, Bounds(gt=0.0, le=100.0)], ...] = ()
    """Scatter of the torques, each from the clamp to one body, that held the poses before release [N m]; none: released
    from rest."""
    release: tuple[Annotated[float, Bounds(ge=0.0, le=100.0)], Annotated[float, Bounds(gt=0.0, le=100.0)]] = (0.0, 1e-3)
    """When these torques begin to fade, and for how long they do [s]."""
    starts: tuple[Annotated[float, Bounds(ge=0.0, le=1e4)], ...] = ()
    """Times after release from which `products` are taken [s]."""
    products: tuple[tuple[Product, ...], ...] = ()
    """For each of `starts` the mean products of the bodies' lateral motions (bodies x bodies, row by row) [m^2] in the
    decays that were identified: from them follow the best fixed ratios between any bodies."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        bodies = len(self.arcs)
        if len(self.base) != len(self.axis):
            raise ValueError(f"base has {len(self.base)} coordinates, axis has {len(self.axis)}")
        if math.hypot(*self.axis) < AXIS_MIN:
            raise ValueError(f"axis = {self.axis} has no direction: its length must be at least {AXIS_MIN}")
        if (self.k_across is None) != (not self.principal):
            raise ValueError("principal and k_across go together")
        if self.principal and (len(self.principal) != len(self.base) or math.hypot(*self.principal) < AXIS_MIN):
            raise ValueError(f"principal = {self.principal} is no direction in {len(self.base)} coordinates")
        if any(inner >= outer for inner, outer in pairwise(self.arcs)):
            raise ValueError(f"arcs = {self.arcs} do not rise from the clamp to the tip")
        if len(self.hold) not in (0, bodies):
            raise ValueError(f"hold has {len(self.hold)} values, arcs has {bodies}")
        if len(self.starts) != len(self.products) or any(len(row) != bodies**2 for row in self.products):
            raise ValueError(f"products need {bodies**2} values (arcs squared) for each of {len(self.starts)} starts")
        return self


class Actuator(Model):
    """A planar pneumatic actuator (paper, table "Model Parameters"), as a chain of `table_rods` rods.

    The model may have another number of rods: it keeps the static map of this table (`controller/assembly/rod.py`).
    """

    name: Annotated[str, spelled(r"^[\w .+-]+$", "letters, digits, blanks and _ . + -", min_length=1, max_length=40)]
    mass: Annotated[float, Bounds(gt=0.0, le=10.0), Q("kg", "m")]
    """The whole body, without the tip load."""
    length: Annotated[float, Bounds(ge=0.01, le=2.0), Q("m", "L")]
    height: Annotated[float, Bounds(ge=1e-4, le=0.5), Q("m")] = 0.0275
    """Out of the plane; drawn, and no more."""
    width: Annotated[float, Bounds(ge=1e-4, le=0.5), Q("m")] = 0.030
    """In the plane; drawn, and no more (the default is ours; the paper gives only the height)."""
    table_rods: Annotated[int, Bounds(ge=2, le=1000), Q("1", "N")] = 10
    """Number of rods that k, b and chambers are given for; joint i lies at the base-side end of rod i."""
    k: Annotated[Profile[Stiffness], Q("N m/rad", "k")]
    """Joint stiffness."""
    b: Annotated[Profile[Damping], Q("N m s/rad", "b")]
    """Joint damping."""
    EI: Annotated[Profile[Rigidity] | None, Q("N m^2", "EI")] = None
    """Bending stiffness of the backbone, from which k and b (b = beta k) then follow for any number of rods."""
    EI_arc: Annotated[tuple[Arc, ...], Bounds(max_length=1000), Q("m", "s")] = ()
    """Arc lengths at which EI is given, rising from the base; none: even from base to tip."""
    beta: Annotated[float, Bounds(ge=0.0, le=10.0), Q("s", "beta")] | None = None
    """Stiffness-proportional Rayleigh damping b / k; goes with EI."""
    alpha: Annotated[float, Bounds(ge=0.0, le=50.0), Q("1/s", "alpha")] = 5.0
    """Mass-proportional Rayleigh damping (ours): sets the first mode's damping ratio, 0.7 for P1. With 0.5 the
    observer's mode with a pinned tip rings, S with it, and at strong bends of P2 the loop through S is unstable."""
    mass_profile: Annotated[Profile[Density], Q("1")] = (1.0,)
    """Mass per length from base to tip, in any unit: only the ratios count."""
    tip_load: Annotated[float, Bounds(ge=0.0, le=10.0), Q("kg")] = 0.0
    """Point mass at the tip."""
    rest_curvature: Annotated[Profile[Curvature], Q("1/m")] = (0.0,)
    """Curvature of the backbone without torque and gravity; positive bends towards +y."""
    gravity: Annotated[tuple[Acceleration, Acceleration], Q("m/s^2", "g", (2,))] = (0.0, 0.0)
    """In the plane's frame: (9.81, 0) for an actuator that hangs from its base."""
    chambers: Annotated[tuple[tuple[Rod, Rod], tuple[Rod, Rod]], Q("1", "T_theta")] = ((0, 5), (5, 10))
    """For u1 and for u2 the rods between which its chamber pair acts: net torque -u on the first, +u on the second.
    0 is the clamp. ((1, 5), (5, 10)) is the other reading of the paper's "proximal, distal, and mid-chamber rod"."""
    chamber_arcs: Annotated[tuple[tuple[Arc, Arc], tuple[Arc, Arc]] | None, Q("m", "s")] = None
    """The same by arc length, where a pair begins and ends at no middle of a rod; takes the place of `chambers`.

    With EI, and neither of both given, the halves: by rods the tip of a body by EI is millimetres off under opposed
    torques, for any number of rods (docs/actuators.md).
    """
    stiffening: Annotated[tuple[Stiffening, Stiffening], Q("1/Pa", "", (2,))] = (0.0, 0.0)
    """Share of k that the pressures of a chamber pair, added, give to it where the pair reaches."""
    stretching: Annotated[tuple[Stretching, Stretching], Q("1/Pa", "", (2,))] = (0.0, 0.0)
    """Share of the length that the pressures of a chamber pair, added, give to it where the pair reaches."""
    u_max: Annotated[float, Bounds(ge=U_MAX_LEAST, le=0.2), Q("N m", "u_max")] = 0.060
    bend_max: Annotated[float, Bounds(ge=0.01, le=12.0), Q("rad")] = 5.6
    """Coupled limit on the static tip angle, counted from rest: beyond it the body would touch itself (ours)."""
    pressure_map: Annotated[PressureSlopes, Q("Pa/(N m)")] = (4.0216e6, 4.0216e6)
    """Pressure per torque, of both pairs (u1, u2) or of each chamber (u1+, u1-, u2+, u2-): with the default, u_max
    needs 35 psi."""
    pressure_max: Annotated[float, Bounds(ge=1e3, le=1e6), Q("Pa", "p_max")] = 241.3e3
    """Highest chamber pressure that is ever commanded (35 psi; the paper gives no range)."""
    tracking: Tracking | None = None
    """Only to identify and observe recorded marker data."""

    @model_validator(mode="wrap")
    @classmethod
    def _given_stiffness(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """With EI, k and b may be left out: they are those of table_rods joints."""
        given = isinstance(data, dict) and data.get("EI") is not None
        found = handler({"k": UNKNOWN, "b": UNKNOWN, **data} if given else data)
        _check_stiffness(found)
        if given:  # in place: pydantic's own __init__ takes no other instance
            found.__dict__.update(_joints(found, data))
            if not data.keys() & {"chambers", "chamber_arcs"}:
                found.__dict__["chamber_arcs"] = halves(found.length)
        return found

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("k", "b", "mass_profile", "rest_curvature"):
            values = len(getattr(self, name))
            if values not in (1, 2, self.table_rods):
                raise ValueError(f"{name} has {values} values: 1, 2 or table_rods = {self.table_rods} are allowed")
        if self.mass < LIGHTEST:
            raise ValueError(f"mass = {self.mass} kg is less than {LIGHTEST} kg")
        for name in ("k", "mass_profile"):
            low, high = min(getattr(self, name)), max(getattr(self, name))
            if high > RATIO_MAX * low:
                raise ValueError(f"{name} goes from {low:g} to {high:g}: {RATIO_MAX:g} to 1 is the most")
        if self.tip_load > RATIO_MAX * self.mass:
            raise ValueError(f"tip_load = {self.tip_load} kg is more than {RATIO_MAX:g} times mass = {self.mass} kg")
        for first, second in self.chambers:
            if not first < second <= self.table_rods:
                raise ValueError(f"chambers ({first}, {second}): first < second <= table_rods = {self.table_rods}")
        for begin, end in self.chamber_arcs or ():
            if not begin < end <= self.length * (1 + ROUNDING):
                raise ValueError(f"chamber_arcs ({begin} m, {end} m): first < second <= length = {self.length} m")
        _check_pressed(self, "stiffening", STIFFER_MAX, f"stiffen {1 + STIFFER_MAX:g} times")
        _check_pressed(self, "stretching", LONGER_MAX, f"lengthen by {LONGER_MAX:.0%}")
        if self.tracking is not None and self.tracking.arcs[-1] > BEYOND * self.length:
            raise ValueError(
                f"length = {self.length} m: tracking.arcs ends at {self.tracking.arcs[-1]} m, beyond the tip"
            )
        if self.tracking is not None and self.tracking.k_across and len(self.tracking.k_across) != len(self.k):
            raise ValueError(f"k has {len(self.k)} values, tracking.k_across {len(self.tracking.k_across)}")
        if len(self.pressure_map) == 3:
            raise ValueError("pressure_map has 3 values: 2 (of the pairs) or 4 (of the chambers) are allowed")
        needed = self.u_max * max(self.pressure_map)
        if needed > self.pressure_max:
            raise ValueError(
                f"u_max = {self.u_max} N m needs {needed:.0f} Pa, above pressure_max = {self.pressure_max}"
            )
        return self

    @property
    def chamber_slopes(self) -> Array:
        """Pressure per torque of the chambers u1+, u1-, u2+, u2- (4,) [Pa/(N m)]."""
        return np.repeat(self.pressure_map, 4 // len(self.pressure_map))

    @property
    def pair_slopes(self) -> Array:
        """The mean of both chambers of each pair (2,) [Pa/(N m)]."""
        return np.asarray(self.chamber_slopes.reshape(2, 2).mean(axis=1))


def _check_pressed(actuator: Actuator, name: str, share_max: float, what: str) -> None:
    """ValueError where two chambers at pressure_max do more than `share_max` by the slopes of this name."""
    most = share_max / (2.0 * actuator.pressure_max)
    for j, share in enumerate(getattr(actuator, name)):
        if share > most:
            raise ValueError(
                f"{name} of pair {j + 1} = {share:g} /Pa is above {most:.3g} /Pa, with which two chambers at "
                f"pressure_max = {actuator.pressure_max:g} Pa {what}"
            )


def halves(length: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Where two pairs of chambers begin and end that share a body evenly [m]."""
    return (0.0, length / 2), (length / 2, length)


def by_joints(actuator: Actuator) -> Actuator:
    """The same actuator with k and b as they are at its table_rods joints, free to be changed: without EI."""
    return actuator.model_copy(update={"EI": None, "EI_arc": (), "beta": None})


def _check_stiffness(actuator: Actuator) -> None:
    """ValueError where EI, EI_arc and beta do not fit together."""
    EI, arc = actuator.EI, actuator.EI_arc
    if EI is None:
        if arc or actuator.beta is not None:
            raise ValueError(f"{'EI_arc' if arc else 'beta'} goes with EI, which is not given")
        return
    if actuator.beta is None:
        raise ValueError("EI needs beta [s], the damping b over k")
    if arc and len(arc) != len(EI):
        raise ValueError(f"EI_arc has {len(arc)} values, EI has {len(EI)}")
    if any(inner >= outer for inner, outer in pairwise(arc)) or (arc and arc[-1] > actuator.length * (1 + ROUNDING)):
        raise ValueError(f"EI_arc = {arc} does not rise from the base up to length = {actuator.length} m")
    if max(EI) > RATIO_MAX * min(EI):
        raise ValueError(f"EI goes from {min(EI):g} to {max(EI):g}: {RATIO_MAX:g} to 1 is the most")


def _joints(actuator: Actuator, data: dict[str, Any]) -> dict[str, Any]:
    """k and b of table_rods joints, from EI and beta; ValueError where `data` say anything else."""
    assert actuator.EI is not None and actuator.beta is not None
    k = joint_stiffness(actuator.EI, actuator.EI_arc, actuator.length, actuator.table_rods)
    for name, values in (("k", k), ("b", actuator.beta * k)):
        if name in data and not same(getattr(actuator, name), values):
            raise ValueError(f"{name} and EI are both given: with EI, k and b follow from EI, EI_arc and beta")
    if not (STIFFNESS_MIN <= k.min() and k.max() <= STIFFNESS_MAX):
        raise ValueError(
            f"EI = {actuator.EI}: joints of {k.min():.3g} to {k.max():.3g} N m/rad are outside "
            f"[{STIFFNESS_MIN:g}, {STIFFNESS_MAX:g}]"
        )
    return {"k": tuple(k.tolist()), "b": tuple((actuator.beta * k).tolist())}


def same(given: tuple[float, ...], found: Array) -> bool:
    """Whether a file that was written from EI still says the same of its joints (N,)."""
    return len(given) == len(found) and bool(np.allclose(given, found, rtol=ROUNDING, atol=0.0))


def read_actuator(source: str | Path) -> Actuator:
    """The preset of this name, or the actuator in this TOML file; ParameterError names what is wrong in it."""
    if str(source) in PRESETS:
        return PRESETS[str(source)]
    path = Path(source)
    if path.suffix != ".toml":
        raise ParameterError(f"actuator = {str(source)!r} is not one of {', '.join(PRESETS)} or a .toml file")
    return _read(path)


def parse_actuator(text: str, source: str) -> Actuator:
    """The actuator in the TOML `text`; ParameterError names `source` and what is wrong in it."""
    return model_in(text, source, Actuator)


def _read(path: Path) -> Actuator:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"{path} cannot be read: {error}") from error
    return parse_actuator(text, str(path))


def write_actuator(actuator: Actuator, path: Path, remark: str = "") -> None:
    """Write `actuator` as TOML with the units beside the numbers, so that `read_actuator` gives it back."""
    lines = [f"# {line}".rstrip() for line in remark.splitlines()]
    tables = []
    derived = set() if actuator.EI is None else {"k", "b"}
    for name, value in actuator.model_dump(mode="json", exclude_none=True, exclude=derived).items():
        if isinstance(value, dict):
            tables += ["", f"[{name}]", *(f"{key} = {json.dumps(item)}" for key, item in value.items())]
        else:
            unit = quantity(Actuator, name).unit
            lines.append(f"{name} = {json.dumps(value)}" + (f"  # {unit}" if unit != "1" else ""))
    path.write_text("\n".join([*lines, *tables, ""]))


def same_body(one: Actuator, other: Actuator) -> bool:
    """Whether both are the same arm, with whichever torques, as a rig's valves bound them."""
    return one.model_copy(update={"u_max": other.u_max}) == other


PRESETS = {path.stem: _read(path) for path in sorted(FOLDER.glob("*.toml"))}
"""The paper's three actuators (table "Model Parameters")."""


def is_of_paper(actuator: Actuator) -> bool:
    """Whether it is one of the paper's three, number for number, so that what was fitted to the paper is its own."""
    return any(same_body(actuator, one) for one in PRESETS.values())
