"""Text from files and command lines comes out of every report as the text it is, whatever it looks like."""

import html.parser
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from markupsafe import Markup

from controller.research.experiments.paper_rows import paper_row
from controller.research.experiments.reproduce import Reproduction, reproduce
from controller.research.experiments.results import Failure, ObserverGain, ResultRow, SweepPoint
from controller.research.identification.fit import Estimate, Fit, Misfit, Plot, PlotSeries
from controller.research.identification.identify import IdentificationTask, save
from controller.research.report import main_table
from controller.research.report import page as reproduction_page
from controller.research.report.figures.plate import Panel, Plate, plate_html
from controller.research.report.page import report_page
from controller.schema.actuator import PRESETS
from controller.schema.fit import FIT
from controller.simulation.case import Case
from controller.simulation.metrics import Window
from controller.text.document import document, table

pytestmark = pytest.mark.keyed()


def hostile(place: str) -> str:
    """A script that would run wherever `place` is put in as markup, in a cell or in an attribute."""
    return f"\" onload='{place}'></td><script>{place}</script>&amp;"


class Seen(html.parser.HTMLParser):
    """Elements, attributes and texts of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.attributes: dict[str, str | None] = {}
        self.text = ""
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes |= dict(attrs)

    def handle_data(self, data: str) -> None:
        self.text += data


def require_text(page: str, *places: str) -> None:
    """All hostile texts of `places` are on the page, as text."""
    seen = Seen(page)
    assert "script" not in seen.tags and "onload" not in seen.attributes
    assert [place for place in places if hostile(place) not in seen.text] == []


def test_an_identification_report_shows_every_text_as_text(tmp_path: Path) -> None:
    line = np.linspace(0.0, 1.0, 5)
    plot = Plot(hostile("plot"), hostile("x"), hostile("y"), (PlotSeries(hostile("series"), line, line),))
    fit = Fit(
        title=hostile("title"),
        method=hostile("method"),
        actuator=PRESETS["P1"],
        parameters=(Estimate(hostile("parameter"), 1.0, 0.9, 1.1, hostile("unit"), hostile("note")),),
        misfits=(Misfit(hostile("misfit"), 1.0, hostile("unit of the misfit"), 3),),
        plots=(plot,),
        notes=(hostile("finding"),),
    )
    base = PRESETS["P1"].model_copy(update={"name": hostile("actuator")})
    task = IdentificationTask((Path("<script>data.csv"),), base, ids=hostile("ids"))
    save(task, [fit], tmp_path / "<script>.toml", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    require_text(page, "plot", "x", "y", "series", "title", "method", "parameter", "unit", "note")
    require_text(page, "misfit", "unit of the misfit", "finding", "actuator", "ids")
    assert "&lt;script&gt;data.csv" in page


def test_a_reproduction_report_shows_every_text_as_text(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduction_page, "processor", lambda: hostile("processor"))
    monkeypatch.setattr(main_table, "remark", lambda row, known: hostile("remark"))
    about = paper_row("vu", "P2", "ff+pi", "rmse")
    named = replace(about, experiment=hostile("experiment"), actuator=hostile("actuator"), law=hostile("law"))
    row = ResultRow(replace(named, unit=hostile("unit"), role="fit"), 3.0, 0.1, Window.WHOLE, 2.0, 2)
    case = Case(hostile("reference"), hostile("actuator of the case"), hostile("law of the case"))
    results = replace(
        reproduce(Reproduction(cases=(Case("digit_1"),), quick=True), lambda case: None),
        outcomes=(),
        rows=(row,),
        failures=(Failure(case, hostile("sentence")), Failure(Case("vu"), hostile("figure"))),
        sweep=(SweepPoint(1.0, None, None, None, None, (None, None), None, hostile("sweep")),),
        observer=(ObserverGain(100.0, 0.0, True, {hostile("observer"): 1.0}),),
    )
    fit = {
        **FIT,
        "fit": {hostile("fact"): hostile("value")},
        "twin": {hostile("fitted"): 1.0},
        "margins": [{hostile("column"): hostile("margin")}],
    }
    page = report_page(results, fit)
    require_text(page, "processor", "remark", "experiment", "actuator", "law", "unit", "sentence", "figure", "sweep")
    require_text(page, "reference", "actuator of the case", "law of the case", "observer")
    require_text(page, "fact", "value", "fitted", "column", "margin")


def test_a_figure_shows_its_texts_as_texts() -> None:
    panel = Panel(hostile("name"), Markup("<svg></svg>"))
    figure = str(plate_html(Plate(hostile("caption"), (panel,), missing=hostile("missing"))))
    require_text(figure, "caption", "missing")
    assert Seen(figure).attributes["aria-label"] == hostile("name")


def test_text_put_where_markup_belongs_is_text() -> None:
    cells = table([hostile("head")], [[f"<b>{hostile('cell')}</b>"]])
    require_text(document(hostile("heading"), cells), "head", "cell", "heading")
    require_text(document("", hostile("body")), "body")  # type: ignore[arg-type]
