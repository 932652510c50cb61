"""The page of `tendril reproduce`: sections in the order of the paper."""

import os
import platform
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from markupsafe import Markup
from pydantic import BaseModel

from controller.errors import TendrilError
from controller.research.experiments.fitted_intervals import paper_fit
from controller.research.experiments.results import ResultRow, Results
from controller.research.report.bars import bars
from controller.research.report.figures.drawing_figures import digit_plates, vu_plate
from controller.research.report.figures.live_figures import live_plate
from controller.research.report.figures.periodic_figures import circle_plate, tracking_plate
from controller.research.report.figures.plate import Plate, plate_html
from controller.research.report.figures.sensing_figures import sensing_plates
from controller.research.report.figures.snapshot_figures import snapshot_plate
from controller.research.report.figures.step_figures import step_plates
from controller.research.report.figures.supplement_figures import pressure_plate, sweep_plate
from controller.research.report.fitted import fields_of, margins_table, provenance
from controller.research.report.main_table import main_table, windows
from controller.research.report.task_tables import (
    bounds_table,
    letter_table,
    observer_table,
    pressure_table,
    sensing_table,
    step_table,
    sweep_table,
)
from controller.research.report.wording import METRICS, metric_name, raised, run_name
from controller.schema.fit import GAIN_NAMES
from controller.schema.layout import quantity
from controller.schema.parameters import ROD_ONLY
from controller.simulation.metrics import UNITS
from controller.text.document import NOTHING, dense, document, joined, table

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


def headline(results: Results, fit: Mapping[str, Any]) -> Markup:
    """Bars as a list, facts as a table."""
    items = joined(Markup("<li>{}</li>").format(one) for one in (*bars(results), failures(results)))
    facts = [*provenance(fit), *circumstances(results)]
    return Markup("<ul>{}</ul>{}").format(items, table(("", ""), facts, ()))


def failures(results: Results) -> str:
    """How many runs did not come to their end."""
    count = len(results.failures)
    return f"{count} of {results.runs} runs failed; see below." if count else "No run failed."


def failed_runs(results: Results) -> Markup:
    """All runs that did not come to their end, with their sentences."""
    rows = [
        (f"{case.reference}, {case.actuator}, {case.law}", str(case.seed), one.sentence)
        for one in results.failures
        for case in (one.case,)
    ]
    return table(("run", "seed", "why"), rows)


def circumstances(results: Results) -> list[tuple[str, str]]:
    """When, where and with which seeds."""
    cores = os.cpu_count() or 1
    return [
        ("run", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC") + (", quick: each once" if results.quick else "")),
        ("machine", f"{processor()}, {cores} cores; Python {platform.python_version()}, {platform.system()}"),
        (
            "time",
            f"{results.seconds:.0f} s with {results.workers} process{'es' * (results.workers > 1)}, this page excluded",
        ),
        ("seeds", ", ".join(map(str, results.seeds))),
    ]


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next(iter(named), platform.processor() or platform.machine())


HEADING = "The paper's experiments on the twin"
ABOUT = (
    "Every experiment of Task-space model-based control of pneumatic soft actuators (Kumar, Gaston, Rucker, Barth, "
    "2026), run without a clock on a simulated actuator through the same tick as the live loop. Errors are those of "
    "the twin's true tip. Bold: the window of the paper's number, the whole run for periodic tasks, after the approach "
    "otherwise."
)
OBSERVER = (
    "Whole run, P1, FF+PI. The paper has K_o = 100 N/m and B_o = 0 and holds a marker from sample to sample; ours is "
    "carried on to the present with its last velocity."
)
LETTER = (
    "RMSE, FF+PI, first seed, in the paper's window: the feedback never fades near a fold, markers are held and not "
    "carried on, the observer's hinges have no damping of ours, and its step is ode4. Gains are those of the fit."
)
BOUNDS = "The paper gives bounds: one range of RMSE for all digits, and largest errors. Small: over the whole run."
FULL = "Bold: the paper's window. Upper number: whole run, approach included; lower number: after the approach."
STYLE = Markup("""
sup { line-height: 0 } small { color: #555 }
figure { margin: 3mm 0 5mm; break-inside: avoid } figcaption { color: #333; margin-bottom: 1mm; break-after: avoid }
.panels { display: grid; gap: 2mm } .panels svg { width: 100%; height: auto } .panels > div { break-inside: avoid }
.of2 { grid-template-columns: 1fr 1fr } .of4 { grid-template-columns: repeat(4, 1fr) }
.of5 { grid-template-columns: repeat(5, 1fr) }
.dense td { white-space: nowrap }
.dense table { font-size: 8pt; line-height: 1.25 } .dense th, .dense td { padding-right: 2.5mm }
.dense table { break-inside: auto } tr { break-inside: avoid }
.met { color: #00634a } .over, .failed { color: #a83e00 }
.met, .over { white-space: nowrap }
@media (max-width: 600px) { .of2 { grid-template-columns: 1fr } .of4, .of5 { grid-template-columns: 1fr 1fr } }
""")


def write_report(results: Results, folder: Path) -> Path:
    """Write `folder`/index.html, one page with nothing outside it, and return its path.

    Raises TendrilError if the folder or the file cannot be written.
    """
    path = folder / "index.html"
    page = report_page(results, paper_fit(results.twin.plant))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise TendrilError(f"cannot write the report {path}: {error.strerror}") from error
    return path


def report_page(results: Results, fit: Mapping[str, Any]) -> str:
    """The whole page; `fit` is the file of the fitted numbers."""
    body = joined(
        (
            Markup('<p class="about">{}</p>').format(ABOUT),
            headline(results, fit),
            section("Beside the paper", main_table(results, fit)),
            section("Step response", step_table(results), step_plates(results)),
            section(
                "Task 1: slow and precise",
                paragraph(BOUNDS) + bounds_table(results),
                [*digit_plates(results), vu_plate(results, "P1")],
            ),
            section("Task 2: fast", NOTHING, fast(results)),
            section("The observer's tip against the true one", paragraph(OBSERVER) + observer_table(results)),
            section("Task 3: other actuators", NOTHING, others(results)),
            section("Task 4: fewer sensors", sensing_table(results), sensing_plates(results)),
            section("Task 5: live reference", NOTHING, [live_plate(results)]),
            section("The paper's law to the letter", paragraph(LETTER) + letter_table(results))
            if results.letter
            else NOTHING,
            section("Frequency sweep", sweep_table(results), [sweep_plate(results)]),
            section("Pressure steps", pressure_table(results), [pressure_plate(results)]),
            section("Failed runs", failed_runs(results)) if results.failures else NOTHING,
            section("All numbers", paragraph(FULL) + full_table(results)),
            section("The twin and the gains", setup_table(results, fit)),
        )
    )
    return document(HEADING, body, STYLE)


def section(title: str, tables: Markup, plates: Sequence[Plate] = ()) -> Markup:
    """A heading over tables and figures."""
    return Markup("<h2>{}</h2>{}{}").format(title, tables, joined(map(plate_html, plates)))


def paragraph(text: str) -> Markup:
    """`text` as a paragraph."""
    return Markup("<p>{}</p>").format(text)


def fast(results: Results) -> list[Plate]:
    """Figures of Task 2."""
    return [
        circle_plate(results),
        snapshot_plate(results),
        tracking_plate(results, "vertical_1hz", "P1", "Vertical line of 60 mm at 1 Hz"),
        tracking_plate(results, "horizontal_1hz", "P1", "Horizontal line of 60 mm at 1 Hz (not drawn in the paper)"),
    ]


def others(results: Results) -> list[Plate]:
    """Figures of Task 3."""
    plates = []
    for actuator in ("P2", "P3"):
        circle = tracking_plate(results, "circle_1hz", actuator, "Circle of 60 mm at 1 Hz")
        plates += [vu_plate(results, actuator), circle]
    return [*plates, tracking_plate(results, "circle_2hz", "P3", "Circle of 60 mm at 2 Hz")]
