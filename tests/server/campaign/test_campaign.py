"""The shortened fault campaign, as anyone runs it."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from controller.system.private_folder import is_private, private_folders
from server.campaign.table import chosen
from server.campaign.waiting import Failed, wait

TENDRIL = Path(sys.executable).parent / "tendril"
KEYS = {"name", "expected", "observed", "reaction_ms", "limit_ms", "pass"}


def rings() -> set[Path]:
    """What campaigns keep in shared memory now, of others too."""
    return {ring for folder in private_folders() if is_private(folder) for ring in folder.glob("tendril-faults-*")}


@pytest.mark.campaign
@pytest.mark.keyed("server", "controller", "recordings", imports=False)
@pytest.mark.timeout(600)
def test_the_shortened_campaign_passes_and_says_so_in_json(tmp_path: Path) -> None:
    file = tmp_path / "faults.json"
    before = rings()
    done = subprocess.run([TENDRIL, "faults", "--quick", "--json", file], capture_output=True, text=True)
    assert file.exists(), done.stdout + done.stderr
    found = json.loads(file.read_text())
    assert found["origin"]["command"].startswith("tendril faults --quick")
    assert set(found) == {"origin", "faults"}
    assert [one["name"] for one in found["faults"]] == [fault.name for fault in chosen(None, quick=True)]
    for one in found["faults"]:
        assert set(one) == KEYS
        assert one["pass"], one
        assert 0 <= one["reaction_ms"] <= one["limit_ms"]
    assert done.returncode == 0
    assert rings() <= before, "nothing is left in shared memory"


@pytest.mark.process
def test_an_unknown_fault_is_one_clear_line() -> None:
    done = subprocess.run([TENDRIL, "faults", "--only", "earthquake"], capture_output=True, text=True)
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1)
    assert "fault = 'earthquake' is not one of server-killed" in done.stderr


def test_what_came_during_a_look_that_took_too_long_is_still_seen() -> None:
    looks = iter([False, True])

    def look() -> bool:
        time.sleep(0.05)
        return next(looks)

    assert wait(look, 0.01, "what came")
    with pytest.raises(Failed, match=r"not within 0\.01 s: what never comes"):
        wait(lambda: False, 0.01, "what never comes")
