"""The fit as a data file: what controller/schema/fit.py reads, and beside it how it was found, what it leaves open."""

import json
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from controller.errors import ParameterError, TendrilError
from controller.research.calibration.margins import Margin
from controller.research.calibration.problem import Evaluation, Problem
from controller.research.calibration.space import Space
from controller.research.calibration.spread import RowSpread, coverage, discrepancy
from controller.research.experiments.paper_rows import PaperRow
from controller.schema.fit import GAIN_NAMES, TWIN

HEADER = "# What `tendril calibrate` found: the twin's unknowns and the gains that the paper does not publish."


@dataclass(frozen=True)
class FitOrigin:
    """How a fit was found."""

    date: str
    command: str
    version: str
    seconds: float
    starts: int
    evaluations: int
    ended: str
    """"finished", "out of time", "interrupted" or "a worker died"."""
    walked: int = 0
    """Rounds of the near-equal fits' walk."""
    accepted: float = 0.0
    """Share of its steps that were taken."""


@dataclass(frozen=True)
class Result:
    """A fit, and what the paper's rows leave open around it."""

    problem: Problem
    best: Evaluation
    fits: tuple[Evaluation, ...]
    """Near-equal ones, the best among them."""
    spread: tuple[RowSpread, ...]
    origin: FitOrigin


def require_toml(out: Path) -> None:
    """Raise ParameterError unless `out` is named as what it becomes."""
    if out.suffix != ".toml":
        raise ParameterError(f"out = {str(out)!r} does not end in .toml")


def fit_text(result: Result) -> str:
    """The file, read back once. The twin's numbers are all that the default file has, so that one can take its place.

    Raises TendrilError for a text that no one could read.
    """
    setup = result.problem.space.decode(result.best.z)
    foreign = setup.twin.plant == "cosserat"
    fitted = (name for name in twin_fields(result.problem.space) if name != "cosserat")
    names = dict.fromkeys([*TWIN, *fitted, *(("plant",) if foreign else ())])
    lines = [
        HEADER,
        *table("[fit]", vars(result.origin) | costs(result)),
        *table(
            "[twin]", {name: getattr(setup.twin, name) for name in names} | ({"plant": "cosserat"} if foreign else {})
        ),
        *(table("[twin.cosserat]", setup.twin.cosserat.model_dump()) if foreign else ()),
        *table("[gains]", {name: getattr(setup.gains, name)[0] for name in GAIN_NAMES}),
    ]
    for margin in result.best.margins:
        lines += table("[[margins]]", margin_entry(margin))
    for row, (ours, _) in zip(result.problem.rows, result.best.predicted, strict=True):
        lines += table("[[rows]]", row_entry(row) | {"ours": shortened(ours), "ratio": shortened(ratio(row, ours))})
    for one in result.spread:
        lines += table("[[spread]]", spread_entry(one))
    if result.spread:
        lines += table("[discrepancy]", discrepancy_entry(result))
    lines += table("[ensemble]", ensemble_entry(result))
    text = "\n".join(lines) + "\n"
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise TendrilError(f"the fit is no TOML: {error}") from error
    return text


def costs(result: Result) -> dict[str, Any]:
    """What the best fit costs, how many are as good, and what these cost in the middle and at most."""
    found = sorted(fit.cost for fit in result.fits)
    middle, most = found[len(found) // 2], found[-1]
    numbers = {"accepted": result.origin.accepted, "cost": result.best.cost, "cost_median": middle, "cost_most": most}
    return {name: shortened(number) for name, number in numbers.items()} | {"fits": len(result.fits)}


def ensemble_entry(result: Result) -> dict[str, Any]:
    """Every near-equal fit, the best first: the unknowns' names, and their values fit by fit."""
    values = [result.problem.space.values(fit.z) for fit in result.fits]
    return {"names": tuple(values[0]), "values": tuple(tuple(one.values()) for one in values)}


def discrepancy_entry(result: Result) -> dict[str, Any]:
    """What every interval was widened by, and how many of the fit rows hold the paper's number with it."""
    inside, rows = coverage(result.spread)
    size = discrepancy(result.problem.rows, result.fits)
    return {"size": shortened(size), "fit_rows_inside": inside, "fit_rows": rows}


def twin_fields(space: Space) -> Iterable[str]:
    """Fields of TwinParameters in which there is an unknown."""
    return (one.name.partition(".")[0] for one in space.unknowns if one.name not in GAIN_NAMES)


def row_entry(row: PaperRow) -> dict[str, Any]:
    """What a row is about, and the paper's number."""
    named = zip(("experiment", "actuator", "law", "metric"), row.key, strict=True)
    return dict(named) | {"paper": row.paper}


def ratio(row: PaperRow, ours: float) -> float:
    """Ours over the paper's; nan where there is none."""
    return ours / row.paper if row.paper else math.nan


def spread_entry(one: RowSpread) -> dict[str, Any]:
    """A row under the near-equal fits."""
    numbers = {name: shortened(getattr(one, name)) for name in ("best", "low", "median", "high")}
    return row_entry(one.row) | {"role": one.row.role} | numbers | {"numbers": one.numbers, "inside": one.inside}


def margin_entry(margin: Margin) -> dict[str, Any]:
    """A trial of stability: the swing in mm."""
    return vars(margin.trial) | {"swing_mm": shortened(1e3 * margin.swing), "growth": shortened(margin.growth)}


def shortened(number: float) -> float:
    """Four digits of a number that is reported, and never read back into a run."""
    return float(f"{number:.4g}")


def table(name: str, entries: Mapping[str, Any]) -> list[str]:
    """Lines of one TOML table."""
    return ["", name, *(f"{key} = {toml(value)}" for key, value in entries.items())]


def toml(value: Any) -> str:
    """A number, bool, text or tuple as TOML; floats with every digit, so that they are read back bit by bit."""
    if isinstance(value, tuple):
        return "[" + ", ".join(toml(one) for one in value) + "]"
    if isinstance(value, float):
        return repr(float(value)) if math.isfinite(value) else str(value)
    if isinstance(value, int):
        return json.dumps(value)
    text = str(value).encode(errors="replace").decode()  # an argument that is no UTF-8 has a lone surrogate
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # escaped as in JSON, but for DEL
