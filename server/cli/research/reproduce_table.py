"""The tables that `tendril reproduce` prints."""

from math import isnan
from statistics import mean

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from controller.research.experiments.paper_rows import CONSULTED, FIT, HELD_OUT, NONE, SENSING_LAWS
from controller.research.experiments.results import ResultRow, Results, SensedLaw, SensedTrajectory
from controller.research.report.bars import bars
from controller.research.report.remarks import known_remarks, outdated
from controller.research.report.verdict import verdict
from controller.simulation.case import Case
from controller.simulation.metrics import Window
from server.cli.tables import empty, number

COLOURS = {True: "green", False: "red", None: "default"}
NUMBERS = ("paper", "ours", "ratio", "interval", "other")
HEADS = ("experiment", "", "law", "metric", *NUMBERS, "")


def show(results: Results, console: Console) -> None:
    """The main table, the summaries of Task 4 and the sweep, failures, and how many rows are within the bars."""
    console.print(main_table(results.rows))
    if results.sensing:
        console.print(sensing_table(results.sensing))
    for line in (*sweep_lines(results), *failure_lines(results), *summary_lines(results)):
        console.print(line, highlight=False, soft_wrap=True)


def main_table(rows: tuple[ResultRow, ...]) -> Table:
    """Every row for which the paper gives a number, by role, and the live path, for which it gives none."""
    table = empty("Ours beside the paper's [mm; ise mm^2 s; lag deg]", HEADS, NUMBERS)
    for role in (FIT, CONSULTED, HELD_OUT, NONE):
        shown = [row for row in rows if row.about.role == role and in_main_table(row)]
        if shown:
            table.add_section()
            table.add_row(f"[bold]{role}[/]")
        for row in shown:
            table.add_row(*cells(row))
    return table


def in_main_table(row: ResultRow) -> bool:
    """Whether the paper gives a number; of the live path, for which it gives none, the error alone."""
    return row.about.paper is not None or (row.about.experiment, row.about.metric) == ("live_path", "rmse")


def cells(row: ResultRow) -> tuple[str, ...]:
    """A row as text."""
    about, judgement = row.about, verdict(row)
    return (
        *(about.experiment, about.actuator, about.law, about.metric),
        number(about.paper),
        number(row.ours) + ("" if row.ours_std is None else f" ± {row.ours_std:.2f}"),
        "-" if row.ratio is None else f"{row.ratio:.2f}",
        interval_text(row),
        number(row.ours_other_window),
        f"[{COLOURS[judgement.met]}]{judgement.word}[/]",
    )


def interval_text(row: ResultRow) -> str:
    """The interval of the near-equal fits, red where the paper's number is outside."""
    if row.interval is None:
        return "-"
    return f"[{COLOURS[row.inside]}]{number(row.interval[0])}..{number(row.interval[1])}[/]"


def sensing_table(trajectories: tuple[SensedTrajectory, ...]) -> Table:
    """Task 4: mean RMSE of each choice of sensors, the paper's reduction by rod 6, p of rod 10 against 6+10."""
    laws = ("ff", "rod6", "paper", "rod10", "rod6+10")
    table = empty("Task 4: RMSE [mm], and against FF", ("", *laws, "order", "p"), (*laws, "order", "p"))
    for one in trajectories:
        by_law = {law.law: law for law in one.laws}
        ff, rod6, rod10, both = (sensed_text(by_law.get(law)) for law in SENSING_LAWS)
        p_value = "-" if one.p_value is None else f"{one.p_value:.2g}"
        order = "paper's" if one.ordered else "another"
        table.add_row(one.experiment, ff, rod6, f"{-one.paper_reduction:+.0%}", rod10, both, order, p_value)
    return table


def sensed_text(one: SensedLaw | None) -> str:
    """Mean RMSE [mm], and by how much it differs from that of FF, if that came to its end."""
    if one is None:
        return "failed"
    return f"{mean(one.rmse):.1f}" + ("" if one.law == "ff" or isnan(one.reduction) else f" ({-one.reduction:+.0%})")


def sweep_lines(results: Results) -> list[str]:
    """The share of the feedback over frequency in one line."""
    if not results.sweep:
        return []
    ours = ", ".join(
        f"{point.frequency:g} Hz " + ("failed" if point.share is None else f"{point.share:.0%}")
        for point in results.sweep
    )
    paper = ", ".join(f"{point.frequency:g} Hz {point.paper:.0%}" for point in results.sweep if point.paper is not None)
    return [f"Share of the feedback in the command: {ours} (paper: {paper})."]


def failure_lines(results: Results) -> list[str]:
    """Each run that did not come to its end or whose recording could not be written, with its reason."""
    return [f"[red]Failed[/]: {named(one.case)}: {escape(one.sentence)}" for one in results.failures] + [
        f"[red]Not recorded[/]: {named(one.case)}: {escape(one.unkept)}" for one in results.outcomes if one.unkept
    ]


def named(case: Case) -> str:
    """A run as markup."""
    return escape(f"{case.reference} {case.actuator} {case.law}, seed {case.seed}")


def summary_lines(results: Results) -> list[str]:
    """The bars, which window is meant, and how long it took."""
    return [
        *bars(results),
        *(f"The remark on {one} is out of date: the row is near." for one in outdated(results.rows, known_remarks())),
        f"Window: {Window.WHOLE.value} for periodic tasks and the live path, {Window.AFTER_APPROACH.value} for "
        "the rest; beside it the other one.",
        f"{results.runs} runs in {results.seconds:.0f} s over {results.workers} processes.",
    ]
