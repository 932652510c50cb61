"""The supplement: share of the feedback by frequency, and steps of the chambers' pressures."""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from controller.research.experiments.results import PressureStep, Results, SweepPoint
from controller.research.report.figures.look import KPA, PAPER, REFERENCE, key
from controller.research.report.figures.plate import Plate, panel

OURS: Any = {"color": "#0072B2", "marker": "o", "markersize": 3.5, "linewidth": 1.1}
SECOND: Any = {"color": "#882255", "marker": "s", "markersize": 3.2, "linewidth": 1.1, "linestyle": (0, (5, 1.5))}
LINE_STYLES = ("-", (0, (5, 1.5)), "-.", ":")
"""Line styles of the pressure steps that one drawing holds."""
MEASURED = "#009E73"


def sweep_plate(results: Results) -> Plate:
    """Share of the feedback in the command, and the phase, by frequency."""
    points = [point for point in results.sweep if point.share is not None]
    caption = (
        "Frequency sweep with the circle of 60 mm, P1 under FF+PI (shape and actuator are ours). Left: share of the "
        "feedback in the command, dashed with K_FF = 0, crosses are the paper's. Right: phase lag of the tip."
    )
    missing = " ".join(f"Failed at {point.frequency:g} Hz: {point.failed}" for point in results.sweep if point.failed)
    if not points:
        return Plate(caption, missing=missing or "Not run: frequency sweep.")
    both = (
        panel("share of the feedback by frequency", partial(_draw_share, results.sweep)),
        panel("phase lag by frequency", partial(_draw_lag, points)),
    )
    return Plate(caption, both, missing=missing)


def pressure_plate(results: Results) -> Plate:
    """Chambers that are filled and chambers that are emptied."""
    caption = "Steps of a chamber's pressure setpoint on the twin, up and down; the setpoint is dashed."
    kinds = {
        "filled": [s for s in results.pressure if s.rises],
        "emptied": [s for s in results.pressure if not s.rises],
    }
    panels = tuple(panel(f"chamber {kind}", partial(_draw_pressure, kind, s)) for kind, s in kinds.items() if s)
    return Plate(caption, panels, missing="" if panels else "Not run: pressure steps.")


def _draw_share(points: tuple[SweepPoint, ...], figure: Figure) -> None:
    axes = figure.add_subplot()
    ours = [(p.frequency, 100.0 * p.share, 100.0 * (p.share_std or 0.0)) for p in points if p.share is not None]
    f, share, std = zip(*ours, strict=True)
    axes.errorbar(f, share, std if any(std) else None, label="ours", **OURS)
    alone = [(p.frequency, 100.0 * p.share_pi) for p in points if p.share_pi is not None]
    if alone:
        axes.plot(*zip(*alone, strict=True), label="ours, K_FF = 0", **SECOND)
    paper = [(p.frequency, 100.0 * p.paper) for p in points if p.paper is not None]
    if paper:
        axes.plot(*zip(*paper, strict=True), label="paper", **PAPER)
    axes.set(ylabel="share of the feedback [%]", ylim=(0.0, None))
    _frequencies(axes, [p.frequency for p in points])
    key(figure, axes)


def _draw_lag(points: list[SweepPoint], figure: Figure) -> None:
    axes = figure.add_subplot()
    for axis, look in enumerate((OURS, SECOND)):
        lags = [np.nan if (lag := p.lag_deg[axis]) is None else lag for p in points]
        axes.plot([p.frequency for p in points], lags, label="xy"[axis], **look)
    axes.set(ylabel="phase lag [deg]")
    _frequencies(axes, [p.frequency for p in points])
    key(figure, axes)


def _frequencies(axes: Axes, frequencies: list[float]) -> None:
    """Logarithmic, with a tick at each frequency."""
    axes.set_xscale("log")
    axes.set_xticks(frequencies, [f"{f:g}" for f in frequencies])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("frequency [Hz]")


def _draw_pressure(kind: str, steps: list[PressureStep], figure: Figure) -> None:
    axes = figure.add_subplot()
    for step, style in zip(steps, LINE_STYLES * len(steps), strict=False):
        name = f"{step.begin * KPA:.0f} to {step.end * KPA:.0f} kPa"
        axes.plot(step.t, step.pressure * KPA, color=MEASURED, linestyle=style, linewidth=1.2, label=name)
        setpoint = [step.begin * KPA, step.begin * KPA, step.end * KPA, step.end * KPA]
        axes.plot([-0.02, 0.0, 0.0, step.t[-1]], setpoint, **{**REFERENCE, "linewidth": 0.9})
    axes.set(title=f"chamber {kind}", xlabel="time since the step [s]", ylabel="pressure [kPa]")
    key(figure, axes, 2)
