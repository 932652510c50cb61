"""A figure of the report: a caption over some panels, or the sentence why there are none."""

from collections.abc import Callable
from dataclasses import dataclass

from markupsafe import Markup
from matplotlib.figure import Figure

from controller.research.drawing import svg
from controller.research.experiments.results import Finished, Results
from controller.research.report.figures.look import LAW_NAMES
from controller.text.document import joined

HALF, TALL, FIFTH = (3.5, 2.6), (3.5, 3.3), (1.45, 1.5)
"""Sizes of panels [inch]: two or five of them side by side on A4, so that text is equally large in all."""


@dataclass(frozen=True)
class Panel:
    """One drawing."""

    name: str
    """What it shows, for those who cannot see it."""
    picture: Markup
    """An <svg> element."""


@dataclass(frozen=True)
class Plate:
    """One figure as in the paper."""

    caption: str
    panels: tuple[Panel, ...] = ()
    columns: int = 2
    """Panels side by side: 2, 4 or 5."""
    missing: str = ""
    """Why there are no panels."""


def panel(name: str, draw: Callable[[Figure], None], size: tuple[float, float] = HALF) -> Panel:
    """What `draw` puts into a figure of `size` [inch]."""
    return Panel(name, svg(draw, size))


def plate_html(plate: Plate) -> Markup:
    """`plate` as a <figure>."""
    picture = Markup('<div role="img" aria-label="{}">{}</div>')
    pictures = joined(picture.format(one.name, one.picture) for one in plate.panels)
    panels = Markup('<div class="panels of{}">{}</div>').format(plate.columns, pictures) if pictures else pictures
    below = Markup('<p class="failed">{}</p>').format(plate.missing) if plate.missing else ""
    return Markup("<figure><figcaption>{}</figcaption>{}{}</figure>").format(plate.caption, panels, below)


def first(results: Results, reference: str, actuator: str = "P1", law: str = "ff+pi") -> Finished | None:
    """The run that figures show: the first of a case that came to its end."""
    return next(iter(results.of(reference, actuator, law)), None)


def why_missing(results: Results, reference: str, actuator: str = "P1", law: str = "ff+pi") -> str:
    """Why `first` found nothing."""
    wanted = reference, actuator, law
    for one in results.failures:
        if (one.case.reference, one.case.actuator, one.case.law) == wanted:
            return f"Failed: {one.sentence}"
    return f"Not run: {reference}, {actuator}, {LAW_NAMES.get(law, law)}."


def plate_of(
    results: Results,
    reference: str,
    actuator: str,
    caption: str,
    draw: Callable[[Finished], tuple[Panel, ...]],
    columns: int = 2,
) -> Plate:
    """The figure of one run under FF+PI, or why there is none."""
    run = first(results, reference, actuator)
    if run is None:
        return Plate(caption, missing=why_missing(results, reference, actuator))
    return Plate(caption, draw(run), columns)
