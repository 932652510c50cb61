"""A fault that the rig was not ready for says nothing of the fault: it is tried again, and says so."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from rich.console import Console

from server.campaign import campaign
from server.campaign.campaign import ATTEMPTS_MAX, NOT_TRIED, Campaign
from server.campaign.table import FAULTS
from server.campaign.waiting import Failed, NotTried, Seen, before_the_fault

FAULT = FAULTS[0]


@pytest.fixture
def tries(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Exception | Seen]]:
    """What comes of the fault, each time that it is tried; there is no scene."""
    given: list[Exception | Seen] = []

    def act(_: object) -> Seen:
        outcome = given.pop(0)
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    monkeypatch.setitem(campaign.ACTS, FAULT.name, act)
    monkeypatch.setattr(Campaign, "_at", lambda self, fault: None)
    monkeypatch.setattr(Campaign, "_machine_stood_still", lambda self, start: False)
    yield given


def judged(tmp_path: Path) -> tuple[bool, str]:
    (verdict,) = Campaign(Console(quiet=True), tmp_path).run([FAULT])
    return verdict["pass"], verdict["observed"]


def test_it_is_tried_again_until_the_rig_was_ready(tries: list[Exception | Seen], tmp_path: Path) -> None:
    tries += [NotTried("no lease"), NotTried("no lease"), Seen("HOLD", 1.0)]
    assert judged(tmp_path) == (True, "HOLD")


def test_what_was_never_tried_says_so_and_has_not_passed(tries: list[Exception | Seen], tmp_path: Path) -> None:
    tries += [NotTried("no lease")] * ATTEMPTS_MAX
    assert judged(tmp_path) == (False, f"{NOT_TRIED}: no lease")


def test_what_went_wrong_after_the_fault_is_judged_at_once(tries: list[Exception | Seen], tmp_path: Path) -> None:
    tries += [Failed("it moved"), Seen("HOLD", 1.0)]
    assert judged(tmp_path) == (False, "it moved")
    assert len(tries) == 1


def test_only_what_fails_before_the_fault_counts_as_not_tried() -> None:
    with pytest.raises(NotTried, match="no lease"), before_the_fault():
        raise Failed("no lease")
