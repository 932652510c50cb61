"""Names and numbers of rows as a reader wants them."""

import math
import re

from markupsafe import Markup

from controller.research.experiments.paper_rows import PaperRow
from controller.research.report.figures.look import LAW_NAMES
from controller.text.document import joined

MISSING = "-"
SMALLEST = 1e-3
"""A standard deviation below this is printed as this."""
METRICS = {
    "rmse": "RMSE",
    "sse": "SSE",
    "ise": "ISE",
    "step_spread": "spread of the steps",
    "max_x": "largest |e_x|",
    "max_y": "largest |e_y|",
    "lag_deg_x": "phase lag x",
    "lag_deg_y": "phase lag y",
    "observer_rmse": "observer RMSE",
    "feedback_share": "feedback share",
    "reduction": "RMSE below FF's by",
}


def number(value: float | None) -> str:
    """`value` to about three digits; a dash where there is none."""
    if value is None or not math.isfinite(value):
        return MISSING
    size = abs(value)
    return f"{value:.{0 if size >= 100 else 1 if size >= 10 else 2}f}"


def with_spread(value: float | None, std: float | None) -> str:
    """`value`, and its standard deviation over the seeds where there are several."""
    if value is None or std is None:
        return number(value)
    return f"{number(value)}\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}{max(std, SMALLEST):.1g}"


def bold(text: str) -> Markup:
    """`text` in bold."""
    return Markup("<b>{}</b>").format(text)


def raised(text: str) -> Markup:
    """`text` with its powers raised, as that of "mm^2"."""
    parts = re.split(r"\^(\d)", text)
    return joined(Markup("<sup>{}</sup>").format(part) if i % 2 else part for i, part in enumerate(parts))


def metric_name(metric: str, unit: str) -> Markup:
    """Metric and its unit."""
    return raised(METRICS[metric] + ("" if unit == "1" else f" [{unit}]"))


def run_name(row: PaperRow) -> str:
    """Experiment, actuator and law."""
    return f"{row.experiment}, {row.actuator}, {LAW_NAMES.get(row.law, row.law)}"


def paper_text(row: PaperRow) -> str:
    """The paper's number and bounds."""
    low, high = row.paper_low, row.paper_high
    limits = f"{low:g} .. {high:g}" if low is not None and high is not None else f"< {high:g}" if high else ""
    if row.paper is None:
        return limits or MISSING
    return f"{row.paper:g}" + (f" ({limits})" if limits else "")
