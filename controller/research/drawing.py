"""A drawing by matplotlib as SVG text: texts as texts, the same bytes for the same drawing, nothing outside it."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
from markupsafe import Markup
from matplotlib.figure import Figure

from controller.errors import TendrilError

RC: Any = {
    "text.parse_math": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "tendril",
    "font.family": "sans-serif",
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.color": "#dddddd",
    "legend.frameon": False,
    "legend.fontsize": 7.0,
}


def save(draw: Callable[[Figure], None], path: Path, size: tuple[float, float], about: str) -> None:
    """What `draw` puts into a figure of `size` [inch], as .svg or .pdf, with `about` in its metadata.

    Raises TendrilError when it cannot be written.
    """
    keys = {"svg": {"Date": None, "Description": about}, "pdf": {"CreationDate": None, "Subject": about}}
    with matplotlib.rc_context(RC | {"pdf.fonttype": 42}):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        try:
            figure.savefig(path, metadata=keys[path.suffix.removeprefix(".")])
        except OSError as error:
            raise TendrilError(f"{path} cannot be written: {error.strerror}") from error


def svg(draw: Callable[[Figure], None], size: tuple[float, float] = (3.5, 2.6)) -> Markup:
    """What `draw` puts into a figure of `size` [inch], as an <svg> element."""
    with matplotlib.rc_context(RC):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        file = io.StringIO()
        figure.savefig(file, format="svg", dpi=200, metadata={"Date": None, "Creator": None})
    text = file.getvalue()
    return Markup(text[text.index("<svg") :])  # noqa: S704  matplotlib escapes every text
