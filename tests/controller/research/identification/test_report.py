import re

import numpy as np
import pytest

from controller.research.identification.fit import Estimate, Fit, Misfit, Plot, PlotSeries
from controller.research.identification.report.report import number_text, report_page
from controller.schema.actuator import PRESETS
from tests.controller.balance import Balance

pytestmark = pytest.mark.keyed()

t = np.linspace(0.0, 3.0, 4000)
PLOT = Plot(
    "Decay <1>",
    "time [s]",
    "y [mm]",
    (PlotSeries("measured", t, np.sin(t), "points"), PlotSeries("model", t, np.cos(t))),
)
FIT = Fit(
    title="Stiffness & damping",
    method="Least squares.",
    actuator=PRESETS["P1"],
    parameters=(Estimate("k", 0.07512, 0.0748, 0.0754, "N m/rad"), Estimate("zeta", 0.07, 0.07, 0.07, "1", "given")),
    misfits=(Misfit("markers", 0.2041, "mm", 120),),
    plots=(PLOT,),
    notes=("One value lies far out.",),
)


def test_the_page_shows_every_number_with_unit_and_confidence_and_needs_nothing_else() -> None:
    page = report_page("P1 & more", "poses.csv", [FIT], 'name = "P1"\n')
    for text in (
        "P1 &amp; more",
        "0.07512",
        "0.07480 .. 0.07540",
        "N m/rad",
        "0.204",
        "time [s]",
        "One value lies far out.",
    ):
        assert text in page
    assert "Decay &lt;1&gt;" in page
    assert re.findall(r'(?:src|href)="(?!#|data:)', page) == []
    assert len(page) < 300_000
    balance = Balance()
    balance.feed(page)
    assert balance.open == []


def test_a_number_is_written_to_two_digits_of_its_uncertainty() -> None:
    assert number_text(0.0751234, 0.0003) == "0.07512"
    assert number_text(1.6712e-4, 3.2e-6) == "1.671e-04"
    assert number_text(1234.567, 12.0) == "1235"
    assert number_text(0.0751234, 0.0) == "0.07512"
    assert number_text(float("nan"), 1.0) == "-"
