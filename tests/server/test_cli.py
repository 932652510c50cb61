"""The command line: a user's mistake is answered in one line that names it."""

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from controller.errors import TendrilError
from server.app.run import listen

TENDRIL = Path(sys.executable).parent / "tendril"


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["rig", "--actuator", "P9"], "actuator = 'P9' is not one of P1, P2, P3"),
        (
            ["rig", "--rods", "20"],
            "dt = 0.001 s is too long for RK4 with this actuator and rods = 20",
        ),
        (["bench", "--quick", "--json", "/nowhere/figures.json"], "/nowhere/figures.json cannot be written"),
        (["rig", "--actuator", "[/odd] [red].toml"], "[/odd] [red].toml cannot be read"),
        (["up", "--port", "99999"], "port = 99999: Input should be less than or equal to 65535"),
        (["serve", "--rig", "no spaces"], "rig = no spaces: String should match pattern"),
    ],
)
def test_a_wrong_value_is_named_in_one_line(arguments: list[str], complaint: str) -> None:
    done = subprocess.run([TENDRIL, *arguments], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert complaint in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_port_in_use_is_named() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(TendrilError, match=f"port = {port}: Address already in use"):
            listen("127.0.0.1", port)
