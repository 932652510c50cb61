"""The campaign's table: one act and one row for each fault, and the same in the documentation."""

from pathlib import Path

import pytest

from controller.errors import ParameterError
from controller.text.markdown import filled
from server.campaign.campaign import ACTS
from server.campaign.table import FAULTS, chosen, markdown

PAGE = Path(__file__).parents[3] / "docs" / "faults.md"


def test_every_fault_of_the_table_can_be_injected_and_no_other() -> None:
    assert [fault.name for fault in FAULTS] == list(ACTS)


def test_the_documentation_shows_the_table() -> None:
    page = PAGE.read_text()
    assert filled(page, "faults", markdown()) == page, "run `make schema`"


def test_a_campaign_is_chosen_by_names_and_by_length() -> None:
    assert chosen(None, quick=False) == list(FAULTS)
    assert 0 < len(chosen(None, quick=True)) < 10
    assert [fault.name for fault in chosen("rig-killed, server-killed", quick=False)] == ["server-killed", "rig-killed"]
    with pytest.raises(ParameterError, match="fault = 'rig-kiled' is not one of server-killed, "):
        chosen("rig-kiled", quick=False)
