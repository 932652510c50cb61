"""Every number of every experiment, in both windows, and the numbers of the twin and the controller behind them."""

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup
from pydantic import BaseModel

from controller.research.experiments.results import ResultRow, Results
from controller.research.report.fitted import fields_of, margins_table
from controller.research.report.main_table import windows
from controller.research.report.wording import METRICS, metric_name, raised, run_name
from controller.schema.fit import GAIN_NAMES
from controller.schema.layout import quantity
from controller.schema.parameters import ROD_ONLY
from controller.simulation.metrics import UNITS
from controller.text.document import dense, table

GAINS = (*GAIN_NAMES, "K_o", "B_o")


def full_table(results: Results) -> Markup:
    """A row for each run, a column for each metric: whole run above, after the approach below."""
    runs: dict[str, dict[str, ResultRow]] = {}
    for row in results.rows:
        runs.setdefault(run_name(row.about), {})[row.about.metric] = row
    used = [metric for metric in METRICS if any(metric in found for found in runs.values())]
    head = ["run", *(metric_name(metric, UNITS[metric][0]) for metric in used)]
    rows = [[name, *(_both(found.get(metric)) for metric in used)] for name, found in runs.items()]
    return dense(table(head, rows, range(1, len(head))))


def setup_table(results: Results, fit: Mapping[str, Any]) -> Markup:
    """Numbers of the twin and gains of the controller; which of them were fitted, and how firmly the loop is stable."""
    gains, twin = results.setup.gains, results.twin
    foreign = twin.plant == "cosserat"
    left_out = {"plant", "cosserat", "seed", *(ROD_ONLY if foreign else ())}
    rows: list[tuple[str, str, str, str]] = [("plant", twin.plant, "", "")]
    rows += [_number(twin, name, name in fit["twin"]) for name in type(twin).model_fields if name not in left_out]
    own = fields_of(fit)
    rows += [_number(twin.cosserat, name, name in own) for name in type(twin.cosserat).model_fields if foreign]
    rows += [_number(gains, name, name in fit["gains"]) for name in GAINS]
    return dense(table(("number", "value", "unit", ""), rows)) + margins_table(fit)


def _both(row: ResultRow | None) -> str:
    return "" if row is None else "failed" if row.failed else Markup("<br>").join(windows(row))


def _number(model: BaseModel, name: str, is_fitted: bool) -> tuple[str, str, str, str]:
    value = getattr(model, name)
    values = value if isinstance(value, tuple) else (value,)
    unit = quantity(type(model), name).unit
    return name, ", ".join(f"{one:.4g}" for one in values), raised(unit) if unit != "1" else "", "fitted" * is_fitted
