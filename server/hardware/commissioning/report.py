"""The report: every step with its numbers and figures, and the rig file, as one HTML page with nothing outside it.

Whatever is not `Markup` is text, and is escaped.
"""

import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from pydantic import JsonValue

from controller.schema.messages import RigInfo
from controller.schema.palette import MEASURED, OBSERVER, REFERENCE, css
from controller.system.origin import our_version
from controller.text.document import document, joined, table
from server.hardware.commissioning.messages import CHAMBERS, STEPS, TITLES, Number, StepName
from server.hardware.commissioning.steps import ABOUT, lacking, standing
from server.hardware.commissioning.store import Kept, KeptResult
from server.hardware.messages import RigFileState

STYLE = Markup("""
.fault { color: #a33a00; font-weight: 600 } figcaption { font-size: 8.5pt; font-weight: 600 }
svg text { font-size: 9px; fill: #333 }
""")
GOOD, FAULT = Markup("<p>{}</p>"), Markup("<p class=fault>{}</p>")
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 340.0, 220.0, 44.0, 8.0, 8.0, 30.0
"""Of a figure, and of its margins [px]."""
TICKS = 5


class Curve(NamedTuple):
    """One line of a figure."""

    name: str
    colour: int
    points: Sequence[tuple[float, float]]
    dots: bool = False


def page(file: RigFileState, kept: Kept, info: RigInfo | None) -> str:
    """The whole page: of the rig of `file`, with what was `kept`, and `info` of the rig that runs, if any."""
    rig = file.rig.name if file.rig else "unknown"
    heading = f"Commissioning of rig {rig}"
    parts = [_about(info), _missing(file), _overview(file, kept)]
    parts += [_section(step, kept.results[step]) for step in STEPS if step in kept.results]
    parts.append(Markup("<h2>Rig file</h2><p class=about>{}</p><pre>{}</pre>").format(file.path, file.text))
    return document(heading, joined(parts), STYLE)


def _about(info: RigInfo | None) -> Markup:
    program = info.program if info else f"Tendril {our_version()}"
    plant = "simulated" if info and info.twin else "hardware" if info else "not connected"
    actuator = info.parameters.actuator.name if info else "unknown"
    text = f"{program}, {datetime.now(UTC):%Y-%m-%d %H:%M} UTC. Actuator {actuator}, plant: {plant}. SI units."
    return Markup("<p class=about>{}</p>").format(text)


def _missing(file: RigFileState) -> Markup:
    missing = lacking(file)
    if not missing:
        return Markup("<p>The rig is commissioned: every step was accepted.</p>")
    return FAULT.format(f"Missing: {'; '.join(missing)}.")


def _overview(file: RigFileState, kept: Kept) -> Markup:
    told = standing(file)
    rows = []
    for step in STEPS:
        result = kept.results.get(step)
        text = result.text if result else told.get(step, "not done")
        if step in file.withdrawn:
            text = f"withdrawn, {file.withdrawn[step]}: {text}"
        when = f"{result.at:%Y-%m-%d %H:%M}" if result else ""
        rows.append((TITLES[step], text, "yes" if step in told else "no", result.by if result else "", when))
    return table(("step", "result", "accepted", "by", "at (UTC)"), rows, ())


def _section(step: StepName, result: KeptResult) -> Markup:
    rows = [_number_row(one) for one in result.numbers]
    changes = [(field, _short(result.before.get(field)), _short(after)) for field, after in result.changes.items()]
    said = result.data.get("said")
    return joined(
        [
            Markup("<h2>{}</h2><p class=about>{}</p>").format(TITLES[step], ABOUT[step].purpose),
            (GOOD if result.good else FAULT).format(result.text),
            table(("number", "value", "95 % interval", "unit", "bound"), rows),
            table(("rig file", "before", "found"), changes, ()),
            table(("what", "before", "after", "difference", "unit"), _pair_rows(result.data), ()),
            _figures(step, result.data),
            Markup("<pre>{}</pre>").format(said) if isinstance(said, str) else Markup(),
        ]
    )


def _number_row(one: Number) -> tuple[str, ...]:
    interval = "" if one.low is None or one.high is None else f"{one.low:.4g} .. {one.high:.4g}"
    bound = one.bound if one.kept or not one.bound else f"{one.bound}: not kept"
    return one.name, "" if one.value is None else f"{one.value:.4g}", interval, one.unit, bound


def _pair_rows(data: Mapping[str, JsonValue]) -> list[tuple[str, ...]]:
    """Every pair of what was measured before and after something was done."""
    pairs, rows = data.get("pairs"), []
    for one in pairs if isinstance(pairs, list) else []:
        if isinstance(one, dict):
            before, after = (np.array(one[name], float) for name in ("before", "after"))
            ways = [_short(values.tolist()) for values in (before, after, after - before)]
            rows.append((str(one["what"]), *ways, str(one["unit"])))
    return rows


def _figures(step: StepName, data: Mapping[str, JsonValue]) -> Markup:
    """What the step's data show; nothing where there are none."""
    figures = []
    if step == "pressure":
        figures = [_pressure(name, curve) for name, curve in zip(CHAMBERS, _arrays(data, "curves"), strict=False)]
    elif step == "statics":
        tips = Curve("tip", MEASURED, _pairs(data, "tips"), dots=True)
        figures = [_chart("Tips at rest, x and y", "x [m]", [tips], plan=True)]
    elif step == "decay":
        figures = [
            _chart(f"Release {number}, y of the tip", "t [s]", [Curve("tip", MEASURED, _columns(curve, 0, 2))])
            for number, curve in enumerate(_arrays(data, "curves"), 1)
        ]
    elif step == "closed_loop":
        curves = [Curve("reference", REFERENCE, _pairs(data, "reference")), Curve("tip", MEASURED, _pairs(data, "tip"))]
        figures = [_chart("Circle, x and y", "x [m]", curves, plan=True)]
    return Markup('<div class="plots">{}</div>').format(joined(figures)) if figures else Markup()


def _pressure(name: str, curve: np.ndarray) -> Markup:
    parts = (("asked", REFERENCE, 1), ("measured", MEASURED, 2), ("dead time and lag", OBSERVER, 3))
    kilo = curve * np.array([1.0, 1e-3, 1e-3, 1e-3])
    return _chart(f"{name}, kPa", "t [s]", [Curve(label, colour, _columns(kilo, 0, at)) for label, colour, at in parts])


def _chart(title: str, below: str, curves: Sequence[Curve], plan: bool = False) -> Markup:
    """Lines over common axes, as a figure; a `plan` has equal scales."""
    points = [point for curve in curves for point in curve.points if all(map(math.isfinite, point))]
    if not points:
        return Markup()
    (x_0, x_1), (y_0, y_1) = (_range([point[axis] for point in points]) for axis in (0, 1))
    if plan:
        (x_0, x_1), (y_0, y_1) = _equal((x_0, x_1), (y_0, y_1))

    def place(x: float, y: float) -> tuple[float, float]:
        across = LEFT + (x - x_0) / (x_1 - x_0) * (WIDTH - LEFT - RIGHT)
        return across, TOP + (y_1 - y) / (y_1 - y_0) * (HEIGHT - TOP - BOTTOM)

    parts = []
    for value in _ticks(x_0, x_1):
        across = place(value, y_0)[0]
        parts.append(
            _line(across, TOP, across, HEIGHT - BOTTOM) + _text(across, HEIGHT - BOTTOM + 11, "middle", f"{value:.3g}")
        )
    for value in _ticks(y_0, y_1):
        down = place(x_0, value)[1]
        parts.append(_line(LEFT, down, WIDTH - RIGHT, down) + _text(LEFT - 3, down + 3, "end", f"{value:.3g}"))
    parts += [
        _drawn(curve, [place(*point) for point in curve.points if all(map(math.isfinite, point))]) for curve in curves
    ]
    legend = ", ".join(f"{curve.name}" for curve in curves)
    parts.append(_text(WIDTH - RIGHT, HEIGHT - 4, "end", below))
    for number, curve in enumerate(curves if len(curves) > 1 else ()):
        across = LEFT + 90.0 * number
        parts.append(Markup('<circle cx="{}" cy="{}" r="3" fill="{}"/>').format(across, HEIGHT - 7, css(curve.colour)))
        parts.append(_text(across + 6, HEIGHT - 4, "start", curve.name))
    svg = Markup('<svg viewBox="0 0 {} {}" role="img" aria-label="{}: {}">{}</svg>').format(
        int(WIDTH), int(HEIGHT), title, legend, joined(parts)
    )
    return Markup("<figure><figcaption>{}</figcaption>{}</figure>").format(title, svg)


def _drawn(curve: Curve, places: Sequence[tuple[float, float]]) -> Markup:
    if curve.dots:
        dot = Markup('<circle cx="{:.1f}" cy="{:.1f}" r="2.5" fill="{}"/>')
        return joined(dot.format(x, y, css(curve.colour)) for x, y in places)
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    return Markup('<polyline points="{}" fill="none" stroke="{}" stroke-width="1.2"/>').format(line, css(curve.colour))


def _line(x_0: float, y_0: float, x_1: float, y_1: float) -> Markup:
    return Markup('<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="#ddd"/>').format(x_0, y_0, x_1, y_1)


def _text(x: float, y: float, anchor: str, words: str) -> Markup:
    return Markup('<text x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>').format(x, y, anchor, words)


def _equal(x: tuple[float, float], y: tuple[float, float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """The same ranges, the shorter widened about its middle so that both have one scale."""
    wide, high = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
    scale = max((x[1] - x[0]) / wide, (y[1] - y[0]) / high)
    middle_x, middle_y = (x[0] + x[1]) / 2, (y[0] + y[1]) / 2
    half_x, half_y = scale * wide / 2, scale * high / 2
    return (middle_x - half_x, middle_x + half_x), (middle_y - half_y, middle_y + half_y)


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers between `low` and `high`, TICKS or some more."""
    raw = (high - low) / TICKS
    power = 10.0 ** math.floor(math.log10(raw))
    step = power * max(one for one in (1.0, 2.0, 5.0) if one * power <= raw * (1.0 + 1e-9))
    first = math.ceil(low / step)
    return [number * step for number in range(first, math.floor(high / step) + 1)]


def _range(values: Sequence[float]) -> tuple[float, float]:
    low, high = min(values), max(values)
    margin = 0.05 * (high - low) or 1e-3
    return low - margin, high + margin


def _arrays(data: Mapping[str, JsonValue], name: str) -> list[np.ndarray]:
    found = data.get(name)
    return [np.array(one, float) for one in found] if isinstance(found, list) else []


def _pairs(data: Mapping[str, JsonValue], name: str) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in _arrays(data, name)]


def _columns(rows: np.ndarray, x: int, y: int) -> list[tuple[float, float]]:
    return list(zip(rows[:, x].tolist(), rows[:, y].tolist(), strict=True))


def _short(value: JsonValue) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return f"[{', '.join(map(_short, value))}]"
    return "" if value is None else str(value)
