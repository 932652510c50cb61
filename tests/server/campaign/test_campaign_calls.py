"""What the campaign breaks from inside is there to be broken."""

import importlib
import re
from functools import reduce
from pathlib import Path

import pytest

ROWS = Path(__file__).parents[3] / "server" / "campaign" / "rows"
CALLS = sorted(
    {call for file in ROWS.glob("*.py") for call in re.findall(r'"([a-z_.]+:\w+(?:\.\w+)*)"', file.read_text())}
)


@pytest.mark.parametrize("call", CALLS)
def test_every_call_that_the_campaign_breaks_is_there(call: str) -> None:
    module, path = call.split(":")
    assert callable(reduce(getattr, path.split("."), importlib.import_module(module)))


def test_calls_are_found_at_all() -> None:
    assert len(CALLS) >= 5
