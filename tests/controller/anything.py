"""Actuators of any kind: near the paper's, anywhere within the bounds of their fields, and beyond them."""

import math
from typing import Any

from annotated_types import Ge, Gt, Le
from hypothesis import strategies as some

from controller.schema.actuator import PRESETS, Actuator, Curvature, Damping, Density, PressureSlope, Stiffness
from controller.schema.parameters import SafetyLimits

P1 = PRESETS["P1"]
WILD = some.sampled_from([0.0, -1.0, 1e-300, 5e-324, 1e300, math.inf, -math.inf, math.nan])


def bounds(kind: Any) -> tuple[float, float]:
    """Least and largest value of an annotated number."""
    marks = [mark for one in kind.__metadata__ for mark in getattr(one, "metadata", [one])]
    low = next((m.ge for m in marks if isinstance(m, Ge)), next((m.gt for m in marks if isinstance(m, Gt)), 0.0))
    return float(low), float(next(m.le for m in marks if isinstance(m, Le)))


def field_bounds(name: str) -> tuple[float, float]:
    marks = Actuator.model_fields[name].metadata
    low = next((m.ge for m in marks if isinstance(m, Ge)), next((m.gt for m in marks if isinstance(m, Gt)), 0.0))
    return float(low), float(next(m.le for m in marks if isinstance(m, Le)))


def within(low: float, high: float, usual: float, alike: bool = False) -> some.SearchStrategy[float]:
    """A number: `alike` near `usual`, else within an octave of it, and now and then anywhere, on a bound or tiny."""
    octaves = 0.15 if alike else 1.0
    near = some.floats(-octaves, octaves).map(lambda x: min(high, max(low, (usual or 0.1 * high) * 2.0**x)))
    if alike:
        return near
    tiny = max(low, 1e-6 * high)
    sizes = some.floats(math.log(tiny), math.log(high)).map(lambda x: min(high, max(low, math.exp(x))))
    rare = some.one_of(some.floats(low, high), sizes, some.sampled_from([low, high]))
    return some.integers(0, 19).flatmap(lambda n: rare if n == 0 else near)


def profiles(kind: Any, usual: float, rods: int, alike: bool) -> some.SearchStrategy[Any]:
    number = within(*bounds(kind), usual, alike)
    return number | some.lists(number, min_size=2, max_size=2) | some.lists(number, min_size=rods, max_size=rods)


@some.composite
def actuators(draw: some.DrawFn) -> dict[str, Any]:
    """Fields of an actuator, each as a page may send it: half of them are much like the paper's, most of which run."""
    alike = draw(some.booleans())
    rods = 10 if alike else draw(some.sampled_from([2, 3, 10, 10, 10, 10, 25]))
    scalars = ("mass", "length", "height", "width", "alpha", "tip_load", "u_max", "bend_max", "pressure_max")
    fields: dict[str, Any] = {name: draw(within(*field_bounds(name), getattr(P1, name), alike)) for name in scalars}
    fields |= {"name": "any", "table_rods": rods}
    fields["k"] = draw(profiles(Stiffness, P1.k[0] * 10 / rods, rods, alike))
    fields["b"] = draw(profiles(Damping, P1.b[0] * 10 / rods, rods, alike))
    fields["mass_profile"] = draw(profiles(Density, 1.0, rods, alike))
    fields["rest_curvature"] = draw(some.just(0.0) | profiles(Curvature, 3.0, rods, alike))
    fields["gravity"] = draw(some.just([0.0, 0.0]) | some.lists(some.floats(-20.0, 20.0), min_size=2, max_size=2))
    slope = within(*bounds(PressureSlope), P1.pressure_map[0], alike)
    slopes = some.sampled_from([2, 4]).flatmap(lambda count: some.lists(slope, min_size=count, max_size=count))
    fields["pressure_map"] = draw(some.just(list(P1.pressure_map)) | slopes)
    fields["stretching"] = draw(some.just([0.0, 0.0]) | some.lists(some.floats(0.0, 5e-7), min_size=2, max_size=2))
    middle = draw(some.integers(1, rods - 1))
    pairs = some.lists(some.integers(0, rods), min_size=2, max_size=2)
    fields["chambers"] = draw(
        some.just([[0, middle], [middle, rods]]) | some.lists(pairs.map(sorted), min_size=2, max_size=2)
    )
    if draw(some.integers(0, 9)):  # as pressures have to fit, most would be refused for them alone
        steepest = max(fields["pressure_map"])
        fields["u_max"] = min(fields["u_max"], 0.97 * SafetyLimits().pressure_max / max(steepest, 1e-9))
        fields["pressure_max"] = min(1e6, fields["u_max"] * steepest * 1.01)
    if draw(some.sampled_from([False] * 9 + [True])):
        name = draw(some.sampled_from(sorted(set(fields) - {"name"})))
        fields[name] = draw(WILD | some.lists(WILD, min_size=1, max_size=3))
    return fields
