"""Tables of single experiments: the steps, Task 4, the frequency sweep, the chambers."""

import math

from markupsafe import Markup

from controller.research.experiments.paper_rows import DIGITS, SENSING_LAWS, STEP_LAWS, STEP_TABLE
from controller.research.experiments.results import ResultRow, Results, SensedLaw, SensedTrajectory, SweepPoint
from controller.research.report.figures.look import KPA, LAW_NAMES
from controller.research.report.figures.sensing_figures import NAMES
from controller.research.report.main_table import mark
from controller.research.report.verdict import Verdict, verdict
from controller.research.report.wording import METRICS, MISSING, bold, number, paper_text, raised, with_spread
from controller.text.document import dense, table

STEP_METRICS = ("rmse", "sse", "ise")
BOUNDED = ("rmse", "max_x", "max_y")
STEP_HEAD = tuple(map(raised, ("RMSE [mm]", "SSE [mm]", "ISE [mm^2 s]")))


def step_table(results: Results) -> Markup:
    """The paper's table of the step response, ours beside it."""
    found = {row.about.key[2:]: row for row in results.rows if row.about.experiment == "step"}
    head = ["controller", *(name for column in STEP_HEAD for name in (column + ", paper", "ours"))]
    rows = []
    for law in STEP_LAWS:
        cells = [LAW_NAMES[law]]
        for metric, paper in zip(STEP_METRICS, STEP_TABLE[law], strict=True):
            cells += [f"{paper:g}", _ours(found.get((law, metric)))]
        rows.append(cells)
    return dense(table(head, rows, range(1, 7)))


def bounds_table(results: Results) -> Markup:
    """Rows of Task 1 for which the paper gives bounds, after the approach and (small) over the whole run."""
    found = {row.about.key: row for row in results.rows}
    head = ["run", *(name for metric in BOUNDED for name in (f"{METRICS[metric]} [mm], paper", "ours"))]
    rows = []
    for experiment in (*DIGITS, "digits", "vu"):
        bounded = [found.get((experiment, "P1", "ff+pi", metric)) for metric in BOUNDED]
        rows.append([experiment, *(cell for row in bounded for cell in _bounded(row))])
    return dense(table(head, rows, range(1, 7)))


def sensing_table(results: Results) -> Markup:
    """Mean RMSE and reduction against FF for each trajectory and choice of sensors."""
    laws = (f"{LAW_NAMES[law]} [mm]" for law in SENSING_LAWS)
    head = ["trajectory", *laws, "paper, rod 6", "order", "p, rods 10 and 6+10"]
    return dense(table(head, [_sensing_row(one) for one in results.sensing], (1, 2, 3, 4, 5, 7)))


def sweep_table(results: Results) -> Markup:
    """Share of the feedback, error and phase by frequency."""
    share = ("share, ours [%]", "without K_FF [%]", "share, paper [%]")
    head = ("frequency [Hz]", *share, "RMSE [mm]", "lag x [deg]", "lag y [deg]", "")
    return table(head, [_sweep_row(point) for point in results.sweep], range(7))


def observer_table(results: Results) -> Markup:
    """The observer's error with the paper's gains and others."""
    runs = list(results.observer[0].observer_rmse) if results.observer else []
    head = ("K_o [N/m]", "B_o [N s/m]", "marker", *(f"{name} [mm]" for name in runs))
    rows = [
        (
            f"{one.K_o:g}",
            f"{one.B_o:g}",
            "carried on" if one.carry_on else "held",
            *(f"{mm:.2f}" if math.isfinite(mm := one.observer_rmse[run]) else "broken off" for run in runs),
        )
        for one in results.observer
    ]
    return table(head, rows, (0, 1, *range(3, 3 + len(runs))))


def letter_table(results: Results) -> Markup:
    """RMSE of every run under FF+PI, by our law and by the paper's equations to the letter."""
    rows = [
        (f"{one.experiment}, {one.actuator}", *map(number, (one.paper, one.ours)), one.failed or number(one.letter))
        for one in results.letter
    ]
    return dense(table(("run", "paper [mm]", "ours [mm]", "to the letter [mm]"), rows, (1, 2, 3)))


def pressure_table(results: Results) -> Markup:
    """Dead time and time to 63 % for each step of pressure."""
    rows = [
        (
            f"{step.begin * KPA:.0f} to {step.end * KPA:.0f}",
            "up" if step.rises else "down",
            _milliseconds(step.dead_time),
            _milliseconds(step.t63),
        )
        for step in results.pressure
    ]
    return table(("setpoint [kPa]", "direction", "dead time [ms]", "63 % after it [ms]"), rows, (2, 3))


def _ours(row: ResultRow | None) -> str:
    return MISSING if row is None else "failed" if row.failed else bold(with_spread(row.ours, row.ours_std))


def _bounded(row: ResultRow | None) -> tuple[str, str]:
    if row is None or row.failed:
        return (MISSING, MISSING) if row is None else (paper_text(row.about), "failed")
    texts = bold(number(row.ours)), mark(Verdict("", verdict(row).met)), number(row.ours_other_window)
    return paper_text(row.about), Markup("{} {}<br><small>{}</small>").format(*texts)


def _sensing_row(one: SensedTrajectory) -> list[str]:
    laws = {law.law: law for law in one.laws}
    cells = [NAMES[one.experiment]]
    for name in SENSING_LAWS:
        law = laws.get(name)
        if law is None:
            cells.append("failed")
            continue
        mean = number(sum(law.rmse) / len(law.rmse))
        cells.append(bold(mean) + _reduction(law))
    order = Verdict("as in the paper" if one.ordered else "another", one.ordered)
    return [*cells, f"{-100 * one.paper_reduction:+.0f} %", mark(order), number(one.p_value)]


def _reduction(law: SensedLaw) -> str:
    """Change against FF; nothing for FF itself, or where FF failed."""
    return "" if law.law == "ff" or math.isnan(law.reduction) else f" ({-100 * law.reduction:+.0f} %)"


def _sweep_row(point: SweepPoint) -> list[str]:
    share = with_spread(_percent(point.share), _percent(point.share_std))
    lags = (number(lag) for lag in point.lag_deg)
    return [
        f"{point.frequency:g}",
        share,
        number(_percent(point.share_pi)),
        number(_percent(point.paper)),
        number(point.rmse),
        *lags,
        point.failed,
    ]


def _percent(share: float | None) -> float | None:
    return None if share is None else 100.0 * share


def _milliseconds(seconds: float) -> str:
    return MISSING if math.isnan(seconds) else f"{1e3 * seconds:.0f}"
