"""The page of `tendril reproduce`: sections in the order of the paper."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from controller.errors import TendrilError
from controller.research.experiments.fitted_intervals import paper_fit
from controller.research.experiments.results import Results
from controller.research.report.figures.drawing_figures import digit_plates, vu_plate
from controller.research.report.figures.live_figures import live_plate
from controller.research.report.figures.periodic_figures import circle_plate, tracking_plate
from controller.research.report.figures.plate import Plate, plate_html
from controller.research.report.figures.sensing_figures import sensing_plates
from controller.research.report.figures.snapshot_figures import snapshot_plate
from controller.research.report.figures.step_figures import step_plates
from controller.research.report.figures.supplement_figures import pressure_plate, sweep_plate
from controller.research.report.full_table import full_table, setup_table
from controller.research.report.headline import failed_runs, headline
from controller.research.report.main_table import main_table
from controller.research.report.task_tables import (
    bounds_table,
    letter_table,
    observer_table,
    pressure_table,
    sensing_table,
    step_table,
    sweep_table,
)
from controller.text.document import NOTHING, document, joined

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
