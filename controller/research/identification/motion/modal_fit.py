"""Stiffness taper, tip load, damping and release from free decays of several tracked bodies."""

import math
from collections.abc import Sequence

import numpy as np

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.fit import Estimate, Fit, Misfit
from controller.research.identification.motion.decays import Decay
from controller.research.identification.motion.directions import is_directional
from controller.research.identification.motion.modal import (
    LATE,
    SMALL,
    TRACKING_RATE,
    Form,
    IdentifiedBody,
    Shape,
    small_mode,
)
from controller.research.identification.motion.modal_solve import Found, at_limit, fit_shape, unknowns
from controller.research.identification.offline import estimate, in_plane, offline_observer
from controller.research.identification.plane import PlaneMotion, body_arcs, hanging_axis, project, rest_of
from controller.research.identification.report.modal_plots import modal_plots
from controller.research.identification.score import STARTS, products
from controller.schema.actuator import Actuator, Tracking

TILTED = 0.2
"""Decays with more than this share of their motion outside the main plane are reported."""
MILLI = 1e3
NOTCH = 1.57
"""Half a 95 % confidence interval of a median, in interquartile ranges over sqrt(n)."""


def fit_modes(decays: Sequence[Decay], base: Actuator) -> Fit:
    """The model that best predicts the inner bodies when the offline observer is given the last one alone.

    Its first mode is measured; what that leaves open is fitted. Every decay counts the same, however far it swings.
    Raises DataError for less than two bodies and for bodies that do not hang from the clamp in order.
    """
    body, found, motions = identified(decays, base)
    actuator = body.shaped(found.shape)
    lateral = [
        estimate(offline_observer(in_plane(actuator, one.direction), [decays[0].points.shape[1] - 1]), one)[..., 1]
        for one in motions
    ]
    return Fit(
        title="Stiffness taper and modes from free decays",
        method=_method(motions, decays[0].points.shape[1]),
        actuator=actuator,
        parameters=_estimates(body, found, actuator, base.tip_load > 0.0),
        misfits=_misfits(motions, lateral),
        plots=modal_plots(motions, lateral, actuator),
        notes=(*_notes(motions), *_load_note(found, base), *_search_note(found)),
    )


def identified(
    decays: Sequence[Decay], base: Actuator, form: Form | None = None, rate: float = TRACKING_RATE
) -> tuple[IdentifiedBody, Found, list[PlaneMotion]]:
    """The body, its fitted shape and the motions it was fitted to; without a `form`, of the one that the decays bear.

    Whether stiffness depends on the direction, left-out decays decide (`is_directional`). Linear and geometric profiles
    have as many unknowns: the smaller cost decides.
    """
    if decays[0].points.shape[1] < 2:
        raise DataError("one tracked body says nothing about the others: a modal fit needs at least 2")
    axis = hanging_axis(decays)
    motions = [project(one, axis, -1) for one in decays]
    frame = _frame(decays, motions, axis)
    base = hanging(base, decays[0].points.shape[2])
    mode = small_mode(motions, frame.arcs[-1])
    if form is not None:
        body = IdentifiedBody(base, frame, mode, form, rate)
        return body, fit_shape(motions, body), motions
    directional = is_directional(mode.ratios, mode.directions, np.array(frame.axis))
    bodies = [IdentifiedBody(base, frame, mode, Form(geometric, directional), rate) for geometric in (False, True)]
    return min(((body, fit_shape(motions, body), motions) for body in bodies), key=lambda one: one[1].cost)


def hanging(base: Actuator, dims: int) -> Actuator:
    """`base` under gravity along x if data in space show a hanging body and it has no gravity of its own."""
    return base.model_copy(update={"gravity": (9.81, 0.0)}) if dims == 3 and not any(base.gravity) else base


def _frame(decays: Sequence[Decay], motions: Sequence[PlaneMotion], axis: Array) -> Tracking:
    """Clamp, axis and bodies in the file's coordinates, and the products for fixed ratios."""
    rest = np.mean([rest_of(one)[0] for one in decays], axis=0)
    sums = products(motions)
    return Tracking(
        base=tuple((rest - (rest @ axis) * axis).tolist()),
        axis=tuple(axis.tolist()),
        arcs=tuple(body_arcs(decays, axis).tolist()),
        starts=STARTS[: len(sums)],
        products=sums,
    )


def _method(motions: Sequence[PlaneMotion], last: int) -> str:
    return (
        f"{len(motions)} decays, each in the plane in which body {last} moves most. Frequency and damping ratio: "
        f"medians of what peaks below {100 * SMALL:.0f} % of the length say. The rest: least squares of what the "
        f"offline observer, given body {last} alone, gets wrong about the others, each decay over its own motion, "
        f"whole and from {LATE} s on, and of the first mode's ratios from then on. Intervals: covariance by decays, "
        "Student's t. Free decays fix ratios of masses and stiffness; the scale is the mass of the base actuator."
    )


def _estimates(body: IdentifiedBody, found: Found, actuator: Actuator, load_known: bool) -> tuple[Estimate, ...]:
    shape, tracking = found.shape, actuator.tracking
    names = unknowns(body.form)
    half = dict(zip(names, found.t * np.sqrt(np.diag(found.covariance)), strict=True))

    def log(name: str, field: str, value: float, unit: str) -> Estimate:
        width = float(half[field])
        return Estimate(name, value, value * math.exp(-width), value * math.exp(width), unit)

    def fixed(name: str, value: float, unit: str, note: str = "") -> Estimate:
        return Estimate(name, value, value, value, unit, note)

    assert tracking is not None
    delay, fade = tracking.release
    load = fixed("tip load / mass", actuator.tip_load / actuator.mass, "1", "of the base actuator")
    if not load_known:
        load = log(load.name, "load", load.value, "1")
    return (
        _median("frequency, undamped", body.mode.omegas / math.tau, "Hz"),
        _median("zeta", body.mode.zetas, "1"),
        *_tapers(shape, found, names),
        *_stiffness(actuator, body.form),
        load,
        fixed("beta", actuator.b[0] / actuator.k[0], "s", "from zeta and its share in the damping"),
        fixed("alpha", actuator.alpha, "1/s", "the rest"),
        Estimate("release, delay", delay, max(0.0, delay - half["delay"]), delay + half["delay"], "s"),
        log("release, fade", "fade", fade, "s"),
    )


def _tapers(shape: Shape, found: Found, names: Sequence[str]) -> tuple[Estimate, ...]:
    """One taper, or those of the two principal directions of bending: taper +- |(cos2, sin2)|."""
    apart = math.hypot(shape.cos2, shape.sin2)
    if not apart:
        return (_taper("taper, k tip / k base", shape.taper, found, np.array([name == "taper" for name in names])),)
    slopes = {"taper": 1.0, "cos2": shape.cos2 / apart, "sin2": shape.sin2 / apart}
    both = []
    for name, sign in (("taper, principal direction", 1.0), ("taper, across it", -1.0)):
        way = np.array([slopes.get(one, 0.0) * (1.0 if one == "taper" else sign) for one in names])
        both.append(_taper(name, shape.taper + sign * apart, found, way))
    return tuple(both)


def _taper(name: str, value: float, found: Found, way: Array) -> Estimate:
    half = found.t * math.sqrt(way @ found.covariance @ way)
    return Estimate(name, math.exp(value), math.exp(value - half), math.exp(value + half), "1")


def _stiffness(actuator: Actuator, form: Form) -> list[Estimate]:
    """Ends of the profiles, which follow from frequency and taper."""
    note = f"from frequency and taper, {'geometric' if form.geometric else 'linear'} in between"
    profiles = {"": actuator.k}
    if actuator.tracking is not None and actuator.tracking.k_across is not None:
        profiles[" across"] = actuator.tracking.k_across
    ends = [(f"k{of}, {end} joint", k[at]) for of, k in profiles.items() for end, at in (("base", 0), ("tip", -1))]
    return [Estimate(name, k, k, k, "N m/rad", note) for name, k in ends]


def _median(name: str, values: Array, unit: str) -> Estimate:
    """With the notch of a box plot as its interval, 1.57 interquartile ranges over sqrt(n): no outlier reaches it."""
    middle, low, high = np.percentile(values, [50, 25, 75])
    half = NOTCH * float(high - low) / math.sqrt(values.size)
    note = f"small motion, median of {values.size} decays"
    return Estimate(name, float(middle), float(middle) - half, float(middle) + half, unit, note)


def _misfits(motions: Sequence[PlaneMotion], lateral: Sequence[Array]) -> tuple[Misfit, ...]:
    off = np.concatenate([found - one.lateral for one, found in zip(motions, lateral, strict=True)])
    last = off.shape[1]
    names = [f"body {i + 1} from body {last}" for i in range(last - 1)] + [f"body {last}, sensed"]
    rms = MILLI * np.sqrt(np.mean(np.square(off), axis=0))
    return tuple(Misfit(name, float(one), "mm", len(off)) for name, one in zip(names, rms, strict=True))


def _notes(motions: Sequence[PlaneMotion]) -> tuple[str, ...]:
    tilted = [f"ID {one.id}: {100 * one.outside:.0f} %" for one in motions if one.outside > TILTED]
    if not tilted:
        return ()
    return (f"Much of the last body's motion lies outside the main plane in {', '.join(tilted)}.",)


def _load_note(found: Found, base: Actuator) -> tuple[str, ...]:
    """A sentence when the tip load ran into the end of what is looked for: then the taper is wrong with it."""
    if base.tip_load or not at_limit(found.shape, "load"):
        return ()
    return (
        f"The tip load came out at the end of its range, {math.exp(found.shape.load):.2g} of the mass, so the taper is "
        "in doubt: give the base actuator its tip_load (1e-6 for none).",
    )


def _search_note(found: Found) -> tuple[str, ...]:
    """A sentence when the search gave up: what it printed is where it stood."""
    if found.settled:
        return ()
    return (
        "The search for taper, tip load and release did not settle: their values and intervals are not to be trusted.",
    )
