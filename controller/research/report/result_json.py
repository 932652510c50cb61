"""The JSON file of a reproduction."""

import math
from dataclasses import asdict
from typing import Any

from controller.research.experiments.results import PressureStep, ResultRow, Results, SensedTrajectory
from controller.research.report.remarks import known_remarks, remark
from controller.schema.fit import GAIN_NAMES


def result_json(results: Results) -> dict[str, Any]:
    """Rows, seconds, twin, and beside them what has no place in a row; None for a number that does not exist."""
    found = {
        "rows": [row_json(row) for row in results.rows],
        "seconds": results.seconds,
        "twin": results.twin.model_dump(mode="json"),
        "gains": {name: list(getattr(results.setup.gains, name)) for name in GAIN_NAMES},
        "seeds": list(results.seeds),
        "quick": results.quick,
        "failures": [{**asdict(one.case), "failed": one.sentence} for one in results.failures],
        "sensing": [_sensing(one) for one in results.sensing],
        "pressure_steps": [_pressure(one) for one in results.pressure],
        "observer_gains": [asdict(one) for one in results.observer],
        "paper_law": [asdict(one) for one in results.letter],
    }
    return {name: _without_nan(value) for name, value in found.items()}


def row_json(row: ResultRow) -> dict[str, Any]:
    """The ten keys of every row, and what we add: `interval`, `inside`, `failed` and `remark` where there are any."""
    found = {
        **asdict(row.about),
        "ours": row.ours,
        "ours_std": row.ours_std,
        "window": row.window.value,
        "ours_other_window": row.ours_other_window,
        "seeds": row.seeds,
        **row.extra,
    }
    if row.interval is not None:
        found |= {"interval": list(row.interval), "inside": row.inside}
    notes = {"failed": row.failed, "remark": remark(row, known_remarks())}
    return found | {name: text for name, text in notes.items() if text}


def _sensing(one: SensedTrajectory) -> dict[str, Any]:
    return {
        "experiment": one.experiment,
        "reduction": {law.law: law.reduction for law in one.laws},
        "normalised_rmse": {law.law: list(law.normalised) for law in one.laws},
        "paper_reduction_rod6": one.paper_reduction,
        "paper_order": one.ordered,
        "p_value_rod10_against_rod6+10": one.p_value,
    }


def _pressure(one: PressureStep) -> dict[str, Any]:
    names = {"from_pa": one.begin, "to_pa": one.end}
    return {**names, "dead_time": one.dead_time, "t63": one.t63}


def _without_nan(value: Any) -> Any:
    """`value` with None for every nan, which JSON does not have."""
    if isinstance(value, dict):
        return {name: _without_nan(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
