"""The page and the copies of recordings for rerun show quantities in the same units."""

import re
from pathlib import Path

import pytest

from controller.schema.display import SHOWN
from controller.schema.layout import quantity, record_dtype
from controller.schema.messages import Telemetry

PAGE = Path(__file__).parents[1] / "frontend/src/plots/signals.ts"
LINE = re.compile(r'^  "?([^":]+)"?: \{ unit: "([^"]*)", scale: ([\d.e+-]+),', re.M)


def test_page_and_recordings_show_every_unit_alike() -> None:
    page = {unit: (shown, float(scale)) for unit, shown, scale in LINE.findall(PAGE.read_text())}
    assert page.pop("1") == ("", 1.0)
    assert page == SHOWN


@pytest.mark.parametrize("field", record_dtype(Telemetry).names)
def test_each_quantity_of_a_row_has_a_unit_that_people_read(field: str) -> None:
    unit = quantity(Telemetry, field).unit
    assert unit == "1" or unit in SHOWN
