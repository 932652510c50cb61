"""The units as `tendril systemd` prints them: systemd reads them where it is, and what they promise is in them."""

import re
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

from server.app.shutdown import VENT_MAX_S
from server.app.systemd import unit_text

pytestmark = pytest.mark.alone

TENDRIL = Path(sys.executable).parent / "tendril"
ANALYZE = shutil.which("systemd-analyze")
UNITS = ["rig", "server"]


def settings(text: str) -> dict[str, list[str]]:
    found = defaultdict(list)
    for name, value in re.findall(r"^(\w+)=(.*)$", text, re.MULTILINE):
        found[name].append(value)
    return found


@pytest.mark.parametrize("name", UNITS)
def test_the_command_prints_the_unit_of_this_installation(name: str) -> None:
    printed = subprocess.run([TENDRIL, "systemd", name], capture_output=True, text=True, check=True).stdout
    assert printed == unit_text(name)
    [command] = settings(printed)["ExecStart"]
    program, verb, *options = command.split()
    assert Path(program) == TENDRIL
    assert verb == {"rig": "rig", "server": "serve"}[name]
    asked = subprocess.run([program, verb, "--help"], capture_output=True, text=True, env={"COLUMNS": "200"})
    for option in (word for word in options if word.startswith("--")):
        assert option in asked.stdout, option


@pytest.mark.skipif(ANALYZE is None, reason="no systemd-analyze here; the settings themselves are read below")
@pytest.mark.parametrize(("name", "exposure"), [("rig", 35), ("server", 25)])
def test_systemd_takes_them_and_finds_them_closed(name: str, exposure: int, tmp_path: Path) -> None:
    """`exposure` is ten times what `systemd-analyze security` calls it: 100 is a service without any of this."""
    assert ANALYZE is not None
    unit = tmp_path / f"tendril-{name}.service"
    unit.write_text(unit_text(name))
    verified = subprocess.run([ANALYZE, "verify", "--recursive-errors=no", unit], capture_output=True, text=True)
    assert (verified.returncode, verified.stderr) == (0, "")
    judged = subprocess.run(
        [ANALYZE, "security", "--offline=true", f"--threshold={exposure}", unit], capture_output=True, text=True
    )
    assert judged.returncode == 0, judged.stdout[-400:]


@pytest.mark.parametrize("name", UNITS)
def test_their_kernels_are_those_of_the_sources_that_run(name: str) -> None:
    """With NUMBA_CACHE_DIR nothing would tell changed sources: the hash in the folder's name does."""
    unit = settings(unit_text(name))
    given = dict(part.split("=") for part in unit["Environment"][0].split())
    assert given["XDG_CACHE_HOME"] == f"/var/cache/{unit['CacheDirectory'][0]}"
    assert "NUMBA_CACHE_DIR" not in given


def test_they_run_as_two_users_and_only_the_rig_has_a_privilege() -> None:
    rig, server = (settings(unit_text(name)) for name in UNITS)
    assert {rig["User"][0], server["User"][0]} == {"tendril-rig", "tendril-server"}
    assert (rig["CapabilityBoundingSet"], server["CapabilityBoundingSet"]) == (["CAP_SYS_NICE"], [""])
    assert (rig["LimitRTPRIO"], rig["LimitMEMLOCK"]) == (["99"], ["infinity"])
    for unit in (rig, server):
        assert unit["Restart"] == ["always"]
        assert unit["NoNewPrivileges"] == unit["PrivateTmp"] == ["yes"]
        assert unit["ProtectSystem"] == ["strict"]
        assert unit["StateDirectory"]
        written = [path for path in re.findall(r"/var/\S+", unit["ExecStart"][0] + " " + unit["Environment"][0])]
        allowed = (f"/var/lib/{unit['StateDirectory'][0]}", f"/var/cache/{unit['CacheDirectory'][0]}")
        assert all(path.startswith(allowed) for path in written), "nothing else can be written"


def test_systemd_waits_longer_than_the_rig_may_take_to_vent() -> None:
    assert float(settings(unit_text("server"))["TimeoutStopSec"][0]) > 2 * VENT_MAX_S
